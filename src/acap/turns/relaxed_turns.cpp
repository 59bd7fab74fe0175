// SPDX-License-Identifier: MIT
#include "relaxed_turns.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <deque>
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

/// The same where the turn of j is held.
class HeldEdgeResidual final : public ceres::SizedCostFunction<3, 1> {
  public:
    HeldEdgeResidual(const TurnProblem& problem, int i, int j, int turn_of_j)
        : constant_(problem.rotation_vector(i, 0) - problem.rotation_vector(j, turn_of_j)),
          slope_(kTurn * problem.axis(i)) {}

    bool Evaluate(double const* const* turns, double* residual, double** jacobians) const override {
        Eigen::Map<Eigen::Vector3d> value(residual);
        value = constant_ + turns[0][0] * slope_;
        if (jacobians != nullptr && jacobians[0] != nullptr) {
            std::copy_n(slope_.data(), 3, jacobians[0]);
        }
        return true;
    }

  private:
    Eigen::Vector3d constant_, slope_;
};

ceres::Solver::Options relaxation_options() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.initial_trust_region_radius = 1e12;  // linear: the first full step is the solution
    options.max_num_iterations = 1;
    options.jacobi_scaling = false;
    options.num_threads = 1;  // shapes run in parallel, and results do not depend on threads
    options.logging_type = ceres::SILENT;
    return options;
}

/// The least squares over the turns of `free`, which are changed in place. Borrows nothing else.
class Relaxation {
  public:
    Relaxation(const TurnProblem& problem, const TurnProblem::Turns& turns,
               const std::vector<int>& free)
        : least_squares_(problem_options()), relaxed_(free.size()) {
        const OneRings& rings = problem.graph().rings;
        std::vector<int> place(turns.size(), -1);
        for (std::size_t n = 0; n < free.size(); ++n) {
            place[at(free[n])] = static_cast<int>(n);
            relaxed_[n] = turns[at(free[n])];
        }
        for (double& turn : relaxed_) least_squares_.AddParameterBlock(&turn, 1);
        for (std::size_t n = 0; n < free.size(); ++n) {
            const int i = free[n];
            for (int k = rings.offsets[at(i)]; k < rings.offsets[at(i) + 1]; ++k) {
                const int j = rings.neighbors[at(k)];
                const int other = place[at(j)];
                if (other < 0) {
                    least_squares_.AddResidualBlock(
                        &held_edges_.emplace_back(problem, i, j, turns[at(j)]), nullptr,
                        &relaxed_[n]);
                } else if (i < j) {
                    least_squares_.AddResidualBlock(&edges_.emplace_back(problem, i, j), nullptr,
                                                    &relaxed_[n], &relaxed_[at(other)]);
                }
            }
        }
    }

    const std::vector<double>& solve() {
        pin_blas_threads();
        ceres::Solver::Summary summary;
        ceres::Solve(relaxation_options(), &least_squares_, &summary);
        if (!summary.IsSolutionUsable()) {
            throw NumericalError("relaxation of the turns failed: " + summary.message);
        }
        return relaxed_;
    }

  private:
    static ceres::Problem::Options problem_options() {
        ceres::Problem::Options options;
        options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
        options.disable_all_safety_checks = true;
        return options;
    }

    // Which do not move when more are added.
    std::deque<EdgeResidual> edges_;
    std::deque<HeldEdgeResidual> held_edges_;
    ceres::Problem least_squares_;
    std::vector<double> relaxed_;
};

}  // namespace

TurnProblem::Turns relaxed_turns(const TurnProblem& problem, TurnProblem::Turns turns,
                                 const std::vector<int>& free) {
    if (free.empty()) return turns;
    Relaxation relaxation(problem, turns, free);
    const std::vector<double>& relaxed = relaxation.solve();
    for (std::size_t n = 0; n < free.size(); ++n) {
        turns[at(free[n])] = static_cast<int>(std::lround(relaxed[n]));
    }
    return turns;
}

TurnProblem::Turns relaxed_turns(const TurnProblem& problem) {
    std::vector<int> free;
    for (int i = 0; i < problem.vertex_count(); ++i) {
        if (!problem.is_root(i)) free.push_back(i);
    }
    return relaxed_turns(problem, TurnProblem::Turns(at(problem.vertex_count()), 0), free);
}

}  // namespace mscomp
