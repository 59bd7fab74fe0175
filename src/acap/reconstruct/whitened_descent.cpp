// SPDX-License-Identifier: MIT
#include "whitened_descent.h"

#include <ceres/first_order_function.h>
#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::VectorXd;

/// Where f was looked at.
struct Place {
    std::vector<Point> positions;
    double value = 0;
    std::vector<Point> derivative;
};

double largest_difference(const std::vector<Point>& a, const std::vector<Point>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            largest = std::max(largest, std::abs(a[i][axis] - b[i][axis]));
        }
    }
    return largest;
}

/// What a descent knows, from one start of Ceres to the next.
struct Descent {
    const PositionFunction& f;
    const AnchoredSystem& metric;
    const DescentOptions& options;
    Place best;  // the lowest so far
    int evaluations = 0;
    int steps = 0;
};

/// f at x = start + C⁻ᵀ y / √(2 scale), times `scale`. If A is half the Hessian of f, the Hessian
/// here is the identity. The scale makes the value at the start ½, so that the length of the
/// gradient is 1 if the first step leads to 0: Ceres makes longer ones shorter.
class WhitenedFunction final : public ceres::FirstOrderFunction {
  public:
    explicit WhitenedFunction(Descent& descent)
        : descent_(descent), start_(descent.best), scale_(0.5 / start_.value) {}

    int NumParameters() const override { return size_; }
    bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
        const Eigen::Map<const VectorXd> y(parameters, size_);
        // Ceres begins with the start, where f is known.
        Place place = y.isZero(0) ? start_ : look_at(y);
        if (!std::isfinite(place.value)) return false;
        *cost = scale_ * place.value;
        if (gradient != nullptr) {
            Eigen::Map<VectorXd>(gradient, size_) =
                std::sqrt(0.5 * scale_) * descent_.metric.whitened(place.derivative);
        }
        if (place.value < descent_.best.value) descent_.best = std::move(place);
        return true;
    }

  private:
    Place look_at(const Eigen::Map<const VectorXd>& y) const {
        Place place{descent_.metric.from_whitened(y), 0, {}};
        const double length = 1 / std::sqrt(2 * scale_);
        for (std::size_t i = 0; i < place.positions.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                double& x = place.positions[i][axis];
                x = start_.positions[i][axis] + length * x;
            }
        }
        ++descent_.evaluations;
        place.value = descent_.f(place.positions, place.derivative);
        return place;
    }

    Descent& descent_;
    Place start_;
    double scale_;
    int size_ = static_cast<int>(3 * descent_.metric.unknown_count());
};

/// Counts steps, and stops when they have become small or too many.
class StepWatch final : public ceres::IterationCallback {
  public:
    explicit StepWatch(Descent& descent)
        : descent_(descent), value_(descent.best.value), last_(descent.best.positions) {}

    /// After the last step that was counted.
    double value() const { return value_; }

    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        if (iteration.iteration == 0) return ceres::SOLVER_CONTINUE;
        ++descent_.steps;
        value_ = descent_.best.value;
        const std::vector<Point>& positions = descent_.best.positions;
        if (largest_difference(positions, last_) <= descent_.options.largest_step) {
            return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
        }
        last_ = positions;
        return descent_.evaluations < descent_.options.max_evaluations ? ceres::SOLVER_CONTINUE
                                                                       : ceres::SOLVER_ABORT;
    }

  private:
    Descent& descent_;
    double value_;
    std::vector<Point> last_;
};

enum class End { converged, nothing_found, too_many };

/// One start of Ceres from the best place.
End run_from_best(Descent& descent) {
    ceres::GradientProblemSolver::Options options;
    options.line_search_direction_type = ceres::LBFGS;
    options.max_lbfgs_rank = descent.options.memory;
    options.max_num_iterations = descent.options.max_evaluations;
    options.function_tolerance = descent.options.least_gain;
    options.gradient_tolerance = 0;
    options.parameter_tolerance = 0;
    options.logging_type = ceres::SILENT;
    StepWatch watch(descent);
    options.callbacks.push_back(&watch);
    auto* function = new WhitenedFunction(descent);  // which the problem owns
    VectorXd y = VectorXd::Zero(function->NumParameters());
    const ceres::GradientProblem problem(function);
    ceres::GradientProblemSolver::Summary summary;
    ceres::Solve(options, problem, y.data(), &summary);
    // A last step with a small gain is not reported to the watch.
    const bool fell = descent.best.value < watch.value();
    if (fell) ++descent.steps;
    switch (summary.termination_type) {
        case ceres::USER_SUCCESS:
            return End::converged;
        case ceres::CONVERGENCE:
            // Where a search along a line finds nothing Ceres may call the gain, 0, a small one.
            return fell ? End::converged : End::nothing_found;
        case ceres::FAILURE:
            return End::nothing_found;
        default:
            return End::too_many;
    }
}

/// How far the first step from the best place would move a coordinate.
double next_step(const Descent& descent) {
    double largest = 0;
    for (const Point& step : descent.metric.solve(descent.best.derivative)) {
        for (const double x : step) largest = std::max(largest, std::abs(0.5 * x));
    }
    return largest;
}

}  // namespace

DescentResult descend(const PositionFunction& f, const AnchoredSystem& metric,
                      std::vector<Point>& positions, const DescentOptions& options) {
    Descent descent{f, metric, options, {std::move(positions), 0, {}}};
    descent.best.value = f(descent.best.positions, descent.best.derivative);
    descent.evaluations = 1;
    DescentResult result;
    result.converged = descent.best.value <= 0 || metric.unknown_count() == 0;
    while (!result.converged && descent.evaluations < options.max_evaluations) {
        const double before = descent.best.value;
        const End end = run_from_best(descent);
        result.converged = end == End::converged;
        if (end == End::too_many) break;
        // The curvature that was kept may have misled: once more with the constant matrix alone.
        if (end == End::nothing_found && !(descent.best.value < before)) {
            result.converged = next_step(descent) <= options.largest_step;
            break;
        }
    }
    result.value = descent.best.value;
    result.steps = descent.steps;
    positions = std::move(descent.best.positions);
    return result;
}

}  // namespace mscomp
