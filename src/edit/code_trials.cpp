// SPDX-License-Identifier: MIT
#include "code_trials.h"

#include <algorithm>
#include <cmath>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "values.h"

namespace mscomp {
namespace {

using Eigen::VectorXd;

/// The entries `which` of `all`.
template <class T>
std::vector<T> gathered(std::span<const T> all, std::span<const int> which) {
    std::vector<T> result;
    result.reserve(which.size());
    for (const int i : which) result.push_back(all[at(i)]);
    return result;
}

/// Adds sign times `step` to every point.
void translate(std::vector<Point>& points, const Point& step, double sign) {
    for (Point& point : points) {
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] += sign * step[axis];
    }
}

}  // namespace

CodeTrials::CodeTrials(const CodeObjective& objective, std::span<const Point> truth,
                       std::span<const float> start, const FitSubset& subset)
    : objective_(objective),
      subset_(subset),
      start_(start.begin(), start.end()),
      truth_(gathered(truth, subset.vertices)),
      truth_center_(mean_point(truth_)),
      stiffness_(objective.stiffness(subset.codes)) {
    translate(truth_, truth_center_, -1);
}

Trial CodeTrials::first() const {
    Trial trial;
    trial.codes = start_;
    if (!evaluate(trial)) {
        throw NumericalError("the codes to start from decode to features that are not finite");
    }
    return trial;
}

bool CodeTrials::evaluate(Trial& trial) const {
    trial.features = objective_.codes.rows(trial.codes);
    if (!all_finite(trial.features)) return false;
    compare(trial);
    return true;
}

NormalEquations CodeTrials::normal_equations(const Trial& trial) const {
    NormalEquations equations =
        reduced_normal_equations(derivatives(trial), trial.known, trial.residuals);
    equations.H *= error_scale();
    equations.g *= error_scale();
    equations.H += prior() * Eigen::MatrixXd(stiffness_.asDiagonal());
    equations.g += prior() * (stiffness_.asDiagonal() * departure(trial.codes));
    return equations;
}

std::vector<Point> CodeTrials::placed(const Trial& trial) const {
    std::vector<Point> result = moved(trial.positions, best_rigid_motion(trial.known, truth_));
    translate(result, truth_center_, 1);
    return result;
}

double CodeTrials::prior() const {
    return objective_.options.prior * objective_.options.prior /
           static_cast<double>(subset_.codes.size());
}

double CodeTrials::error_scale() const {
    return objective_.scale * objective_.scale / (3.0 * static_cast<double>(truth_.size()));
}

/// Change of the codes that may move from their start.
VectorXd CodeTrials::departure(const std::vector<float>& codes) const {
    VectorXd result(stiffness_.size());
    for (Eigen::Index n = 0; n < result.size(); ++n) {
        const auto k = at(subset_.codes[at(n)]);
        result[n] = static_cast<double>(codes[k]) - static_cast<double>(start_[k]);
    }
    return result;
}

/// Derivatives of the known vertices (codes,vertices,3), their centroid at 0.
std::vector<double> CodeTrials::derivatives(const Trial& trial) const {
    std::vector<double> all =
        objective_.codes.derivatives(trial.codes, trial.features, subset_.codes);
    // They leave the centroid of all vertices where it is.
    const auto vertex_count = at(objective_.codes.vertex_count());
    if (subset_.vertices.size() == vertex_count) return all;
    std::vector<double> result;
    result.reserve(subset_.codes.size() * subset_.vertices.size() * 3);
    const std::size_t width = 3 * vertex_count;
    for (std::size_t k = 0; k < subset_.codes.size(); ++k) {
        std::vector<Point> column;
        for (const int v : subset_.vertices) {
            const double* p = &all[k * width + 3 * at(v)];
            column.push_back({p[0], p[1], p[2]});
        }
        translate(column, mean_point(column), -1);
        for (const Point& p : column) result.insert(result.end(), p.begin(), p.end());
    }
    return result;
}

/// Positions, residuals and objective of its features.
void CodeTrials::compare(Trial& trial) const {
    trial.positions = objective_.codes.positions(trial.features, {});
    trial.known = gathered(std::span<const Point>(trial.positions), subset_.vertices);
    const Point center = mean_point(trial.known);
    translate(trial.positions, center, -1);
    translate(trial.known, center, -1);
    const std::vector<Point> goal = moved(truth_, best_rigid_motion(truth_, trial.known));
    trial.residuals.resize(goal.size());
    double squares = 0;
    for (std::size_t i = 0; i < goal.size(); ++i) {
        Eigen::Map<Eigen::Vector3d> r(trial.residuals[i].data());
        r = vec(trial.known[i]) - vec(goal[i]);
        squares += r.squaredNorm();
    }
    trial.error = error_scale() * squares;
    const VectorXd away = departure(trial.codes);
    trial.objective = trial.error + prior() * away.dot(stiffness_.asDiagonal() * away);
}

}  // namespace mscomp
