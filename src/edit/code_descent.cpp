// SPDX-License-Identifier: MIT
#include "code_descent.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "reduced_normal_equations.h"

namespace mscomp {
namespace {

using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-3;  // of the diagonal of the normal matrix
constexpr double kMostDamping = 1e8;

Eigen::Map<const Eigen::Vector3d> vec(const Point& point) {
    return Eigen::Map<const Eigen::Vector3d>(point.data());
}

bool all_finite(std::span<const float> values) {
    return std::ranges::all_of(values, [](float x) { return std::isfinite(x); });
}

/// Centroids of connected components.
std::vector<Point> centroids(const std::vector<Point>& points, const std::vector<int>& component) {
    std::vector<Point> result;
    std::vector<int> sizes;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto c = static_cast<std::size_t>(component[i]);
        if (c >= result.size()) {
            result.resize(c + 1, Point{});
            sizes.resize(c + 1, 0);
        }
        ++sizes[c];
        for (std::size_t axis = 0; axis < 3; ++axis) result[c][axis] += points[i][axis];
    }
    for (std::size_t c = 0; c < result.size(); ++c) {
        for (double& x : result[c]) x /= sizes[c];
    }
    return result;
}

/// Adds sign times what `centers` has for its component to every point.
void translate(std::vector<Point>& points, const std::vector<int>& component,
               const std::vector<Point>& centers, double sign) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& center = centers[static_cast<std::size_t>(component[i])];
        for (std::size_t axis = 0; axis < 3; ++axis) points[i][axis] += sign * center[axis];
    }
}

/// Codes with everything that follows from them.
struct Trial {
    std::vector<float> codes;
    std::vector<float> features;
    std::vector<Point> positions;  // every component with its centroid at 0
    std::vector<Point> residuals;  // positions minus the truth, turned to them
    double error = 0;              // mean square of a coordinate, in the unit ball
    double objective = 0;
};

/// The fit of one shape.
class LevenbergMarquardt {
  public:
    LevenbergMarquardt(const CodeObjective& objective, std::span<const Point> truth,
                       std::span<const float> start)
        : objective_(objective),
          start_(start.begin(), start.end()),
          truth_(truth.begin(), truth.end()),
          truth_centers_(centroids(truth_, objective.component)) {
        translate(truth_, objective_.component, truth_centers_, -1);
        best_.codes = start_;
        best_.features = objective_.codes.features(start_);
        if (!all_finite(best_.features)) {
            throw NumericalError("the codes to start from decode to features that are not finite");
        }
        compare(best_);
    }

    FittedShape run() {
        FittedShape result;
        result.initial_rms = rms();
        while (result.steps < objective_.options.max_steps) {
            const double before = best_.objective;
            if (!step()) {
                result.converged = true;
                break;
            }
            ++result.steps;
            if (before - best_.objective <= objective_.options.least_gain * before) {
                result.converged = true;
                break;
            }
        }
        result.rms = rms();
        result.codes = best_.codes;
        result.vertices = moved(best_.positions, best_rigid_motion(best_.positions, truth_));
        translate(result.vertices, objective_.component, truth_centers_, 1);
        return result;
    }

  private:
    double rms() const { return std::sqrt(best_.error) / objective_.scale; }
    double prior() const {
        return objective_.options.prior * objective_.options.prior /
               static_cast<double>(start_.size());
    }
    double error_scale() const {
        return objective_.scale * objective_.scale / (3.0 * static_cast<double>(truth_.size()));
    }

    /// Change of the codes from their start.
    VectorXd departure(const std::vector<float>& codes) const {
        VectorXd result(static_cast<Eigen::Index>(codes.size()));
        for (std::size_t k = 0; k < codes.size(); ++k) {
            result[static_cast<Eigen::Index>(k)] =
                static_cast<double>(codes[k]) - static_cast<double>(start_[k]);
        }
        return result;
    }

    /// Positions, residuals and objective of its features.
    void compare(Trial& trial) const {
        trial.positions = objective_.codes.positions(trial.features, {});
        translate(trial.positions, objective_.component,
                  centroids(trial.positions, objective_.component), -1);
        const std::vector<Point> goal = moved(truth_, best_rigid_motion(truth_, trial.positions));
        trial.residuals.resize(goal.size());
        double squares = 0;
        for (std::size_t i = 0; i < goal.size(); ++i) {
            Eigen::Map<Eigen::Vector3d> r(trial.residuals[i].data());
            r = vec(trial.positions[i]) - vec(goal[i]);
            squares += r.squaredNorm();
        }
        trial.error = error_scale() * squares;
        const VectorXd away = departure(trial.codes);
        trial.objective =
            trial.error + prior() * away.dot(objective_.stiffness.asDiagonal() * away);
    }

    /// One step that lowers the objective; false if none does.
    bool step() {
        NormalEquations equations =
            reduced_normal_equations(objective_.codes.derivatives(best_.codes, best_.features),
                                     best_.positions, best_.residuals);
        equations.H *= error_scale();
        equations.g *= error_scale();
        equations.H += prior() * Eigen::MatrixXd(objective_.stiffness.asDiagonal());
        equations.g += prior() * (objective_.stiffness.asDiagonal() * departure(best_.codes));
        const VectorXd diagonal = equations.H.diagonal();
        const double smallest = 1e-9 * diagonal.maxCoeff();
        if (!(smallest > 0)) return false;
        for (; damping_ <= kMostDamping; damping_ *= raise_, raise_ *= 2) {
            Eigen::MatrixXd damped = equations.H;
            damped.diagonal() += damping_ * diagonal.cwiseMax(smallest);
            const VectorXd change = damped.ldlt().solve(-equations.g);
            const double promised =
                -(2 * equations.g.dot(change) + change.dot(equations.H * change));
            if (!(promised > 0)) continue;
            if (take(change, promised)) return true;
        }
        return false;
    }

    /// Moves by `change` if that lowers the objective, which is said to fall by `promised`.
    bool take(const VectorXd& change, double promised) {
        Trial trial;
        trial.codes = best_.codes;
        for (std::size_t k = 0; k < trial.codes.size(); ++k) {
            trial.codes[k] += static_cast<float>(change[static_cast<Eigen::Index>(k)]);
        }
        trial.features = objective_.codes.features(trial.codes);
        if (!all_finite(trial.features)) return false;
        compare(trial);
        const double gain = best_.objective - trial.objective;
        if (!(gain > 0)) return false;
        const double trust = 2 * std::min(gain / promised, 1.0) - 1;
        damping_ = std::max(1e-12, damping_ * std::max(0.1, 1 - trust * trust * trust));
        raise_ = 2;
        best_ = std::move(trial);
        return true;
    }

    const CodeObjective& objective_;
    std::vector<float> start_;
    std::vector<Point> truth_;          // every component with its centroid at 0, and
    std::vector<Point> truth_centers_;  // where it was
    Trial best_;
    double damping_ = kFirstDamping, raise_ = 2;
};

}  // namespace

FittedShape descend(const CodeObjective& objective, std::span<const Point> truth,
                    std::span<const float> start) {
    return LevenbergMarquardt(objective, truth, start).run();
}

}  // namespace mscomp
