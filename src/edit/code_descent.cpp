// SPDX-License-Identifier: MIT
#include "code_descent.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "reduced_normal_equations.h"
#include "values.h"

namespace mscomp {
namespace {

using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-3;  // of the diagonal of the normal matrix
constexpr double kMostDamping = 1e8;

/// The entries `which` of `all`.
template <class T>
std::vector<T> gathered(std::span<const T> all, std::span<const int> which) {
    std::vector<T> result;
    result.reserve(which.size());
    for (const int i : which) result.push_back(all[at(i)]);
    return result;
}

/// Connected components (V), those without one of `vertices` joined to the first that has one.
std::vector<int> groups_of(const std::vector<int>& component, std::span<const int> vertices) {
    std::vector<char> is_known(component.size(), 0);
    int first = -1;
    for (const int v : vertices) {
        const int c = component[at(v)];
        is_known[at(c)] = 1;
        if (first < 0 || c < first) first = c;
    }
    std::vector<int> result = component;
    for (int& c : result) {
        if (is_known[at(c)] == 0) c = first;
    }
    return result;
}

/// Centroids of groups of points; 0 for a group without points.
std::vector<Point> centroids(const std::vector<Point>& points, const std::vector<int>& group) {
    std::vector<Point> result;
    std::vector<int> sizes;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto c = at(group[i]);
        if (c >= result.size()) {
            result.resize(c + 1, Point{});
            sizes.resize(c + 1, 0);
        }
        ++sizes[c];
        for (std::size_t axis = 0; axis < 3; ++axis) result[c][axis] += points[i][axis];
    }
    for (std::size_t c = 0; c < result.size(); ++c) {
        for (double& x : result[c]) x /= std::max(sizes[c], 1);
    }
    return result;
}

/// Adds sign times what `centers` has for its group to every point.
void translate(std::vector<Point>& points, const std::vector<int>& group,
               const std::vector<Point>& centers, double sign) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Point& center = centers[at(group[i])];
        for (std::size_t axis = 0; axis < 3; ++axis) points[i][axis] += sign * center[axis];
    }
}

/// Codes with everything that follows from them.
struct Trial {
    std::vector<float> codes;
    std::vector<float> features;
    std::vector<Point> positions;  // (V) every group with the centroid of its known vertices at 0
    std::vector<Point> known;      // of these the known ones, and
    std::vector<Point> residuals;  // they minus the truth, turned to them
    double error = 0;              // mean square of a coordinate, in the unit ball
    double objective = 0;
};

/// The fit of one shape. A group is a connected component, or several where not each has a known
/// vertex.
class LevenbergMarquardt {
  public:
    LevenbergMarquardt(const CodeObjective& objective, std::span<const Point> truth,
                       std::span<const float> start, const FitSubset& subset)
        : objective_(objective),
          subset_(subset),
          group_(groups_of(objective.component, subset.vertices)),
          known_group_(gathered(std::span<const int>(group_), subset.vertices)),
          start_(start.begin(), start.end()),
          truth_(gathered(truth, subset.vertices)),
          truth_centers_(centroids(truth_, known_group_)),
          stiffness_(objective.stiffness(subset.codes)) {
        translate(truth_, known_group_, truth_centers_, -1);
        best_.codes = start_;
        best_.features = objective_.codes.rows(start_);
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
        result.vertices = moved(best_.positions, best_rigid_motion(best_.known, truth_));
        translate(result.vertices, group_, truth_centers_, 1);
        return result;
    }

  private:
    double rms() const { return std::sqrt(best_.error) / objective_.scale; }
    double prior() const {
        return objective_.options.prior * objective_.options.prior /
               static_cast<double>(subset_.codes.size());
    }
    double error_scale() const {
        return objective_.scale * objective_.scale / (3.0 * static_cast<double>(truth_.size()));
    }

    /// Change of the codes that may move from their start.
    VectorXd departure(const std::vector<float>& codes) const {
        VectorXd result(stiffness_.size());
        for (Eigen::Index n = 0; n < result.size(); ++n) {
            const auto k = at(subset_.codes[at(n)]);
            result[n] = static_cast<double>(codes[k]) - static_cast<double>(start_[k]);
        }
        return result;
    }

    /// Derivatives of the known vertices (codes,vertices,3), the centroids at 0.
    std::vector<double> derivatives() const {
        std::vector<double> all =
            objective_.codes.derivatives(best_.codes, best_.features, subset_.codes);
        // The solvers leave the centroids of whole components where they are.
        if (subset_.vertices.size() == group_.size()) return all;
        std::vector<double> result;
        result.reserve(subset_.codes.size() * subset_.vertices.size() * 3);
        const std::size_t width = 3 * group_.size();
        for (std::size_t k = 0; k < subset_.codes.size(); ++k) {
            std::vector<Point> column;
            for (const int v : subset_.vertices) {
                const double* p = &all[k * width + 3 * at(v)];
                column.push_back({p[0], p[1], p[2]});
            }
            translate(column, known_group_, centroids(column, known_group_), -1);
            for (const Point& p : column) result.insert(result.end(), p.begin(), p.end());
        }
        return result;
    }

    /// Positions, residuals and objective of its features.
    void compare(Trial& trial) const {
        trial.positions = objective_.codes.positions(trial.features, {});
        trial.known = gathered(std::span<const Point>(trial.positions), subset_.vertices);
        const std::vector<Point> centers = centroids(trial.known, known_group_);
        translate(trial.positions, group_, centers, -1);
        translate(trial.known, known_group_, centers, -1);
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

    /// One step that lowers the objective; false if none does.
    bool step() {
        NormalEquations equations =
            reduced_normal_equations(derivatives(), best_.known, best_.residuals);
        equations.H *= error_scale();
        equations.g *= error_scale();
        equations.H += prior() * Eigen::MatrixXd(stiffness_.asDiagonal());
        equations.g += prior() * (stiffness_.asDiagonal() * departure(best_.codes));
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
        for (Eigen::Index n = 0; n < change.size(); ++n) {
            const int code = subset_.codes[at(n)];
            trial.codes[at(code)] += static_cast<float>(change[n]);
        }
        trial.features = objective_.codes.rows(trial.codes);
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
    const FitSubset& subset_;
    std::vector<int> group_;        // (V) what has a centroid of its own
    std::vector<int> known_group_;  // of the known vertices
    std::vector<float> start_;
    std::vector<Point> truth_;          // known vertices, every group with its centroid at 0, and
    std::vector<Point> truth_centers_;  // where it was
    VectorXd stiffness_;                // of the codes that may move
    Trial best_;
    double damping_ = kFirstDamping, raise_ = 2;
};

}  // namespace

FittedShape descend(const CodeObjective& objective, std::span<const Point> truth,
                    std::span<const float> start, const FitSubset& subset) {
    return LevenbergMarquardt(objective, truth, start, subset).run();
}

}  // namespace mscomp
