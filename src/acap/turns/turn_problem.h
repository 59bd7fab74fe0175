// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <vector>

#include "consistency_graph.h"
#include "mscomp/base/index.h"

namespace mscomp {

inline constexpr double kTurn = 2 * std::numbers::pi;

/// The integer least-squares problem of one shape: choose turns t_i so that
/// E(t) = Σ_edges |r_i(t_i) - r_j(t_j)|² is least, r_i(t) = a_i (θ_i + 2π t), roots at 0.
class TurnProblem {
  public:
    using Turns = std::vector<int>;

    /// `vectors` (V) are what turn 0 stands for; only where they are shorter than 1e-4 another axis
    /// is taken, that of the neighbours. Keeps a reference to `graph`.
    TurnProblem(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& vectors);

    const ConsistencyGraph& graph() const { return graph_; }
    int vertex_count() const { return static_cast<int>(axis_.size()); }
    bool is_root(int vertex) const { return root_[at(vertex)] != 0; }
    const Eigen::Vector3d& axis(int vertex) const { return axis_[at(vertex)]; }
    double angle(int vertex) const { return angle_[at(vertex)]; }
    /// a_i·a_j, beside graph().rings.neighbors.
    const std::vector<double>& cosines() const { return cosine_; }

    Eigen::Vector3d rotation_vector(int vertex, int turn) const {
        return (angle(vertex) + kTurn * turn) * axis(vertex);
    }
    /// The turn that brings `vertex` nearest to `target`; 0 for a root.
    int nearest_turn(int vertex, const Eigen::Vector3d& target) const;

    double energy(const Turns& turns) const;
    /// What E changes by when `vertex` alone goes to `turn`.
    double change(const Turns& turns, int vertex, int turn) const;
    /// The turn of `vertex` that lowers E most while all others stay.
    int best_turn(const Turns& turns, int vertex) const;
    /// Least |r_i - r_j|² over all turns of the two.
    double edge_minimum(int i, int j) const;

    /// From the roots outwards, nearest rotations first (to one part in eight), each vertex nearest
    /// to its predecessor.
    Turns propagated() const;

  private:
    void choose_free_axes(std::vector<char> known);
    /// Σ_j a_i·r_j over the ring of `vertex`.
    double pull(const Turns& turns, int vertex) const;

    const ConsistencyGraph& graph_;
    std::vector<Eigen::Vector3d> axis_;  // (V) unit
    std::vector<double> angle_;  // (V) not negative; at most π where the vectors are principal
    std::vector<double> cosine_;
    std::vector<char> root_;  // (V)
};

}  // namespace mscomp
