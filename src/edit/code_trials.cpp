// SPDX-License-Identifier: MIT
#include "code_trials.h"

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "values.h"

namespace mscomp {

using Eigen::VectorXd;

Trial CodeTrials::first() const {
    Trial trial;
    trial.codes.assign(freedom_.start.begin(), freedom_.start.end());
    if (!evaluate(trial)) {
        throw NumericalError("the codes to start from decode to features that are not finite");
    }
    return trial;
}

bool CodeTrials::evaluate(Trial& trial) const {
    trial.rows = rows(trial.codes);
    if (!all_finite(trial.rows)) return false;
    compare(trial);
    const VectorXd away = departure(trial.codes);
    trial.objective =
        trial.error + freedom_.prior * away.dot(freedom_.stiffness.asDiagonal() * away);
    return true;
}

NormalEquations CodeTrials::normal_equations(const Trial& trial) const {
    NormalEquations equations = error_equations(trial);
    equations.H += freedom_.prior * Eigen::MatrixXd(freedom_.stiffness.asDiagonal());
    equations.g += freedom_.prior * (freedom_.stiffness.asDiagonal() * departure(trial.codes));
    return equations;
}

/// Change of the codes that move from their start.
VectorXd CodeTrials::departure(const std::vector<float>& codes) const {
    VectorXd result(freedom_.stiffness.size());
    for (Eigen::Index n = 0; n < result.size(); ++n) {
        const auto k = at(freedom_.moving[at(n)]);
        result[n] = static_cast<double>(codes[k]) - static_cast<double>(freedom_.start[k]);
    }
    return result;
}

}  // namespace mscomp
