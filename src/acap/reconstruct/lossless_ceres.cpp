// SPDX-License-Identifier: MIT
#include "lossless_ceres.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/linear/blas_threads.h"
#include "ring_residual.h"

namespace mscomp {
namespace {

/// sqrt(weight) (p' - position).
class SoftHandle final : public ceres::SizedCostFunction<3, 3> {
  public:
    explicit SoftHandle(const Handle& handle)
        : position_(handle.position), root_weight_(std::sqrt(handle.weight)) {}

    bool Evaluate(double const* const* positions, double* residuals,
                  double** jacobians) const override {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            residuals[axis] = root_weight_ * (positions[0][axis] - position_[axis]);
        }
        if (jacobians != nullptr && jacobians[0] != nullptr) {
            Eigen::Map<Eigen::Matrix3d> jacobian(jacobians[0]);
            jacobian = root_weight_ * Eigen::Matrix3d::Identity();
        }
        return true;
    }

  private:
    Point position_;
    double root_weight_;
};

ceres::Solver::Options solver_options() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 100;
    // Nearly linear: the first step may go all the way.
    options.initial_trust_region_radius = 1e6;
    options.function_tolerance = 1e-6;  // as the fast path
    options.gradient_tolerance = 0;
    options.parameter_tolerance = 1e-10;
    options.num_threads = 1;  // shapes run in parallel, and results do not depend on threads
    options.logging_type = ceres::SILENT;
    return options;
}

}  // namespace

void refine_by_ceres(const FeatureEquations& equations, const std::vector<Eigen::Matrix3d>& wanted,
                     std::span<const Handle> handles, std::span<const int> held,
                     ReconstructedShape& result) {
    std::vector<Point>& positions = result.vertices;
    const std::vector<RingShape> rings = ring_shapes(equations);
    ceres::Problem problem;
    for (Point& position : positions) problem.AddParameterBlock(position.data(), 3);
    std::vector<double*> members;
    for (std::size_t i = 0; i < rings.size(); ++i) {
        if (rings[i].members.empty()) continue;
        members.clear();
        for (const int vertex : rings[i].members) {
            members.push_back(positions[at(vertex)].data());
        }
        problem.AddResidualBlock(new RingResidual(rings[i], wanted[i]), nullptr, members);
    }
    for (const Handle& handle : handles) {
        Point& position = positions[at(handle.vertex)];
        if (std::isfinite(handle.weight)) {
            problem.AddResidualBlock(new SoftHandle(handle), nullptr, position.data());
        } else {
            position = handle.position;
            problem.SetParameterBlockConstant(position.data());
        }
    }
    for (const int vertex : held) {
        problem.SetParameterBlockConstant(positions[at(vertex)].data());
    }
    pin_blas_threads();
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(), &problem, &summary);
    if (!summary.IsSolutionUsable()) {
        throw NumericalError("lossless reconstruction failed: " + summary.message);
    }
    result.steps = std::max(summary.num_successful_steps - 1, 0);
    result.converged = summary.termination_type == ceres::CONVERGENCE;
}

}  // namespace mscomp
