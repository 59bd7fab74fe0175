// SPDX-License-Identifier: MIT
#include "relaxed_turns.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/linear/blas_threads.h"

namespace mscomp {
namespace {

/// a_i (θ_i + 2π t_i) - a_j (θ_j + 2π t_j) of one edge as a function of two real turns.
class EdgeResidual final : public ceres::SizedCostFunction<3, 1, 1> {
  public:
    EdgeResidual(const TurnProblem& problem, int i, int j)
        : constant_(problem.rotation_vector(i, 0) - problem.rotation_vector(j, 0)),
          slope_i_(kTurn * problem.axis(i)),
          slope_j_(-kTurn * problem.axis(j)) {}

    bool Evaluate(double const* const* turns, double* residual, double** jacobians) const override {
        Eigen::Map<Eigen::Vector3d> value(residual);
        value = constant_ + turns[0][0] * slope_i_ + turns[1][0] * slope_j_;
        if (jacobians == nullptr) return true;
        if (jacobians[0] != nullptr) std::copy_n(slope_i_.data(), 3, jacobians[0]);
        if (jacobians[1] != nullptr) std::copy_n(slope_j_.data(), 3, jacobians[1]);
        return true;
    }

  private:
    Eigen::Vector3d constant_, slope_i_, slope_j_;
};

}  // namespace

TurnProblem::Turns relaxed_turns(const TurnProblem& problem) {
    const auto count = at(problem.vertex_count());
    std::vector<double> relaxed(count, 0.0);
    ceres::Problem least_squares;
    for (double& turn : relaxed) least_squares.AddParameterBlock(&turn, 1);
    for (const auto& [i, j] : problem.graph().edges) {
        least_squares.AddResidualBlock(new EdgeResidual(problem, i, j), nullptr, &relaxed[at(i)],
                                       &relaxed[at(j)]);
    }
    for (const int root : problem.graph().roots) {
        least_squares.SetParameterBlockConstant(&relaxed[at(root)]);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.initial_trust_region_radius = 1e12;  // linear: the first full step is the solution
    options.max_num_iterations = 2;
    options.num_threads = 1;  // shapes run in parallel, and results do not depend on threads
    options.logging_type = ceres::SILENT;
    pin_blas_threads();
    ceres::Solver::Summary summary;
    ceres::Solve(options, &least_squares, &summary);
    if (!summary.IsSolutionUsable()) {
        throw NumericalError("relaxation of the turns failed: " + summary.message);
    }
    TurnProblem::Turns turns(count);
    for (std::size_t i = 0; i < count; ++i) turns[i] = static_cast<int>(std::lround(relaxed[i]));
    return turns;
}

}  // namespace mscomp
