// SPDX-License-Identifier: MIT
#include "vertex_trials.h"

#include <algorithm>
#include <cmath>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "values.h"

namespace mscomp {
namespace {

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

VertexTrials::VertexTrials(const VertexObjective& objective, std::span<const Point> truth,
                           std::span<const float> start, const FitSubset& subset)
    : CodeTrials({start, subset.codes, objective.stiffness(subset.codes),
                  objective.options.prior * objective.options.prior /
                      static_cast<double>(subset.codes.size())}),
      objective_(objective),
      subset_(subset),
      truth_(gathered(truth, subset.vertices)),
      truth_center_(mean_point(truth_)) {
    translate(truth_, truth_center_, -1);
}

std::vector<float> VertexTrials::rows(std::span<const float> codes) const {
    return objective_.codes.rows(codes);
}

NormalEquations VertexTrials::error_equations(const Trial& trial) const {
    NormalEquations equations =
        reduced_normal_equations(derivatives(trial), trial.known, trial.residuals);
    equations.H *= error_scale();
    equations.g *= error_scale();
    return equations;
}

std::vector<Point> VertexTrials::placed(const Trial& trial) const {
    std::vector<Point> result = moved(trial.positions, best_rigid_motion(trial.known, truth_));
    translate(result, truth_center_, 1);
    return result;
}

double VertexTrials::error_scale() const {
    return objective_.scale * objective_.scale / (3.0 * static_cast<double>(truth_.size()));
}

/// Derivatives of the known vertices (codes,vertices,3), their centroid at 0.
std::vector<double> VertexTrials::derivatives(const Trial& trial) const {
    std::vector<double> all = objective_.codes.derivatives(trial.codes, trial.rows, subset_.codes);
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

/// Positions, residuals and their mean square.
void VertexTrials::compare(Trial& trial) const {
    trial.positions = objective_.codes.positions(trial.rows, {});
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
}

}  // namespace mscomp
