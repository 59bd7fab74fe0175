// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <vector>

#include "consistency.h"

namespace mscomp {

inline constexpr double kTurn = 2 * std::numbers::pi;

/// The integer least-squares problem of one shape: choose turns t_i so that
/// E(t) = Σ_edges |r_i(t_i) - r_j(t_j)|² is least, r_i(t) = a_i (θ_i + 2π t), roots at 0.
class TurnProblem {
  public:
    using Turns = std::vector<int>;

    TurnProblem(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& principal);

    const ConsistencyGraph& graph() const { return graph_; }
    int vertex_count() const { return static_cast<int>(axis_.size()); }
    bool is_root(int vertex) const { return root_[static_cast<std::size_t>(vertex)] != 0; }
    const Eigen::Vector3d& axis(int vertex) const {
        return axis_[static_cast<std::size_t>(vertex)];
    }
    double angle(int vertex) const { return angle_[static_cast<std::size_t>(vertex)]; }

    Eigen::Vector3d rotation_vector(int vertex, int turn) const {
        return (angle(vertex) + kTurn * turn) * axis(vertex);
    }
    /// The turn that brings `vertex` nearest to `target`; 0 for a root.
    int nearest_turn(int vertex, const Eigen::Vector3d& target) const;

    double energy(const Turns& turns) const;
    /// Σ over edges of the edge's own minimum over its two integers: never above E(t).
    double lower_bound() const;

    /// From the roots outwards, nearest rotations first, each vertex nearest to its predecessor.
    Turns propagated() const;
    /// Signs that make the axes of neighbours agree along a tree of the most parallel ones.
    std::vector<int> orientation() const;

  private:
    void choose_free_axes(std::vector<char> known);
    double edge_minimum(int i, int j) const;

    const ConsistencyGraph& graph_;
    std::vector<Eigen::Vector3d> axis_;  // (V) unit
    std::vector<double> angle_;          // (V) in [0, π]
    std::vector<char> root_;             // (V)
};

/// Lowers E by moves of single vertices until none helps.
void polish_vertices(const TurnProblem& problem, TurnProblem::Turns& turns);

/// Lowers E by moving any set of vertices by one turn at once, the best set found as a minimum cut,
/// until no set helps. `orientation` says which way is up. Returns true if the result is proved
/// to be the least of all: axes of all neighbours agree, so that E is L-natural convex and a point
/// without a lowering step is a minimum (Murota).
bool polish_clusters(const TurnProblem& problem, const std::vector<int>& orientation,
                     TurnProblem::Turns& turns);

/// The least-squares solution over real turns (one sparse solve by Ceres), rounded.
TurnProblem::Turns relaxed_turns(const TurnProblem& problem);

}  // namespace mscomp
