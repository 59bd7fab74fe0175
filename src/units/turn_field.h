// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

class BlockCholesky;

/// Rotations at the vertices of a mesh as what they turn by along its edges, and back (method §10,
/// space route).
class TurnField {
  public:
    /// Of E edges, i < j, in rising order. `roots` are a vertex of each connected piece, whose
    /// rotations are said and not integrated; empty: the lowest of each. Throws UsageError where
    /// they are not one of each.
    explicit TurnField(const TriangleMesh& mesh, std::vector<int> roots = {});
    TurnField(TurnField&&) noexcept;
    TurnField& operator=(TurnField&&) noexcept;
    ~TurnField();

    int vertex_count() const { return vertex_count_; }
    int edge_count() const { return static_cast<int>(edges_.size()); }
    const std::vector<std::array<int, 2>>& edges() const { return edges_; }
    /// (P), as given, or rising.
    const std::vector<int>& roots() const { return roots_; }
    /// Of each connected piece its vertices, in the order of the roots.
    std::vector<std::vector<int>> pieces() const;

    /// log(R_iᵀ R_j) (E,3) of rotation vectors (V,3), in radians.
    std::vector<float> turns_of(std::span<const float> vectors) const;

    /// A x (V,3): the rotation vectors that turns x (E,3) add up to where they are small, less
    /// their mean over each piece; and its adjoint Aᵀ y (E,3).
    std::vector<Eigen::Vector3d> added_up(const std::vector<Eigen::Vector3d>& turns) const;
    std::vector<Eigen::Vector3d> shared_out(std::vector<Eigen::Vector3d> rotations) const;

    /// Rotation vectors (V,3), those of neighbours on the same turn, of turns ρ (E,3) and the
    /// rotation vectors (P,3) of the roots: along a tree from each root, R_j = R_i exp(ρ_ij), then
    /// corrected twice, R ← exp(δ) R, by the least squares of δ_j - δ_i = log(R_i exp(ρ_ij) R_jᵀ)
    /// with δ = 0 at the roots. Exact where the turns are those of rotations; elsewhere, after the
    /// first correction alone, what comes out would depend on the tree.
    std::vector<Eigen::Vector3d> integrated(const std::vector<Eigen::Vector3d>& turns,
                                            const std::vector<Eigen::Vector3d>& roots) const;

    /// The same, and for each direction of change in turns (E,3) and roots (P,3) how the rotation
    /// vectors (V,3) change.
    struct Direction {
        std::vector<Eigen::Vector3d> turns, roots;
    };
    std::vector<std::vector<Eigen::Vector3d>> derivatives(
        const std::vector<Eigen::Vector3d>& turns, const std::vector<Eigen::Vector3d>& roots,
        const std::vector<Direction>& directions) const;

  private:
    struct Step {  // of the tree
        int edge, from, to;
    };
    struct Pass;
    struct State;

    void grow_tree(const std::vector<int>& wanted);
    void factorise();
    State state_of(const std::vector<Eigen::Vector3d>& turns,
                   const std::vector<Eigen::Vector3d>& roots) const;
    void correct(const std::vector<Eigen::Vector3d>& turns, Pass& pass) const;
    /// δ of the residuals of all edges.
    std::vector<Eigen::Vector3d> corrected(const std::vector<Eigen::Vector3d>& residuals) const;
    /// L⁻¹ of values (V,3), in place; those of the roots become zero.
    void solve_laplacian(std::vector<Eigen::Vector3d>& values) const;
    void subtract_means(std::vector<Eigen::Vector3d>& values) const;

    int vertex_count_ = 0;
    std::vector<std::array<int, 2>> edges_;
    std::vector<int> roots_;
    std::vector<std::size_t> first_step_;  // (P+1) steps of each piece
    std::vector<Step> steps_;              // from the roots outwards
    std::vector<int> unknown_;             // (V) among those that are no roots, -1 for roots
    std::unique_ptr<const BlockCholesky> laplacian_;  // none where there are only roots
};

}  // namespace mscomp
