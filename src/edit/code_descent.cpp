// SPDX-License-Identifier: MIT
#include "code_descent.h"

#include <ceres/cost_function.h>
#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mscomp/base/index.h"
#include "mscomp/linear/blas_threads.h"
#include "reduced_normal_equations.h"

namespace mscomp {
namespace {

using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kSmallestRadius = 1e-8;
constexpr double kSmallestDiagonal = 1e-9;  // of the largest entry

/// The objective of one shape as the sum of squares of K + 1 residuals (small_residuals) in the
/// codes that may move, and the best codes that were tried. Codes are decoded as floats: what Ceres
/// holds in doubles is rounded first.
class CodeCost final : public ceres::CostFunction {
  public:
    CodeCost(const CodeTrials& trials, int max_steps)
        : trials_(trials),
          moving_(trials.freedom().moving),
          max_steps_(max_steps),
          best_(trials.first()) {
        const auto count = static_cast<int>(moving_.size());
        mutable_parameter_block_sizes()->push_back(count);
        set_num_residuals(count + 1);
    }

    bool Evaluate(double const* const* parameters, double* residuals,
                  double** jacobians) const override {
        const auto count = static_cast<Eigen::Index>(moving_.size());
        const Trial* trial = trial_at({parameters[0], at(count)});
        if (trial == nullptr) return false;
        Eigen::Map<VectorXd> values(residuals, count + 1);
        // Ceres wants a derivative at the last place, too, and looks at it no more.
        if (jacobians == nullptr || jacobians[0] == nullptr || is_last()) {
            values.setZero();
            values[count] = std::sqrt(trial->objective);
            if (jacobians != nullptr && jacobians[0] != nullptr) {
                Eigen::Map<VectorXd>(jacobians[0], (count + 1) * count).setZero();
            }
            return true;
        }
        const SmallResiduals small = small_residuals(
            trial == &best_ ? equations_at_best() : trials_.normal_equations(*trial),
            trial->objective);
        values = small.values;
        Eigen::Map<RowMajor>(jacobians[0], count + 1, count) = small.derivative;
        return true;
    }

    const Trial& best() const { return best_; }
    Trial take_best() { return std::move(best_); }
    const NormalEquations& equations_at_best() const {
        if (!equations_) equations_ = trials_.normal_equations(best_);
        return *equations_;
    }
    /// Times that the best became better.
    int steps() const { return steps_; }
    bool is_last() const { return steps_ >= max_steps_; }

  private:
    const Trial* trial_at(std::span<const double> moved) const {
        Trial trial;
        trial.codes = best_.codes;
        for (std::size_t n = 0; n < moved.size(); ++n) {
            trial.codes[at(moving_[n])] = static_cast<float>(moved[n]);
        }
        if (trial.codes == best_.codes) return &best_;
        if (!trials_.evaluate(trial)) return nullptr;
        last_ = std::move(trial);
        if (!(last_.objective < best_.objective)) return &last_;
        ++steps_;
        best_ = std::move(last_);
        equations_.reset();
        return &best_;
    }

    const CodeTrials& trials_;
    std::span<const int> moving_;
    int max_steps_;
    // Ceres evaluates through a const reference.
    mutable Trial best_, last_;
    mutable std::optional<NormalEquations> equations_;  // at the best, once they were needed
    mutable int steps_ = 0;
};

/// Ends the descent after as many steps as are wanted; rejected ones do not count.
class StepLimit final : public ceres::IterationCallback {
  public:
    explicit StepLimit(const CodeCost& cost) : cost_(cost) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
        return cost_.is_last() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
    }

  private:
    const CodeCost& cost_;
};

ceres::Solver::Options solver_options(const DescentOptions& descent, double largest_diagonal) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = std::numeric_limits<int>::max();
    options.initial_trust_region_radius = descent.first_radius;
    options.min_trust_region_radius = kSmallestRadius;
    options.max_trust_region_radius = kUndampedRadius;
    options.min_lm_diagonal = kSmallestDiagonal * largest_diagonal;
    options.min_relative_decrease = 0;
    options.max_num_consecutive_invalid_steps = 30;  // by then the radius is the smallest
    options.jacobi_scaling = false;
    options.function_tolerance = descent.least_gain;
    options.gradient_tolerance = 0;
    options.parameter_tolerance = 0;
    options.num_threads = 1;  // shapes run in parallel, and results do not depend on threads
    options.logging_type = ceres::SILENT;
    return options;
}

ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.disable_all_safety_checks = true;
    return options;
}

}  // namespace

Descent descend(const CodeTrials& trials, const DescentOptions& options) {
    CodeCost cost(trials, options.max_steps);
    Descent result;
    result.initial_error = cost.best().error;
    if (options.max_steps > 0) {
        const CodeFreedom& freedom = trials.freedom();
        std::vector<double> moved;
        for (const int code : freedom.moving) {
            moved.push_back(static_cast<double>(freedom.start[at(code)]));
        }
        ceres::Problem problem(problem_options());
        problem.AddResidualBlock(&cost, nullptr, moved.data());
        StepLimit limit(cost);
        ceres::Solver::Options solver =
            solver_options(options, cost.equations_at_best().H.diagonal().maxCoeff());
        solver.callbacks.push_back(&limit);
        pin_blas_threads();
        ceres::Solver::Summary summary;
        ceres::Solve(solver, &problem, &summary);
        // Whatever else ends it, no step helped enough.
        result.converged = summary.termination_type != ceres::USER_FAILURE;
    }
    result.steps = cost.steps();
    result.best = cost.take_best();
    return result;
}

}  // namespace mscomp
