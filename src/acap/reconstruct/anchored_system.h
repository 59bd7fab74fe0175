// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/linear/block_cholesky.h"

namespace mscomp {

/// The lower triangle of a symmetric matrix; entries of equal place are summed.
using MatrixEntries = std::vector<Eigen::Triplet<double>>;

/// Adds share x the Laplacian Σ_edges c_ij (x_i - x_j)²; `weights` beside rings.neighbors.
void add_laplacian(const OneRings& rings, const std::vector<double>& weights, double share,
                   MatrixEntries& entries);

/// Adds the normal matrix of Σ_i |Σ_j (x_j - x_i) f_ij|² over the neighbours j of i; `factors`
/// beside rings.neighbors.
void add_ring_squares(const OneRings& rings, const std::vector<Eigen::Vector3d>& factors,
                      MatrixEntries& entries);

/// A symmetric positive semidefinite (V,V) matrix whose kernel are the translations of the
/// connected components, made definite by holding one vertex of each at 0, factorised once.
class AnchoredSystem {
  public:
    /// `name` appears in the message; `like`, if given, is a system with the same anchors and about
    /// the same entries, whose order of elimination is taken over. Throws NumericalError if it
    /// cannot be factorised.
    AnchoredSystem(MatrixEntries entries, int vertex_count, const std::vector<int>& anchors,
                   const std::string& name, const AnchoredSystem* like = nullptr);

    int unknown_count() const { return unknown_count_; }
    /// (V) solution of three right-hand sides (V), 0 at the anchors whatever stands there.
    std::vector<Point> solve(const std::vector<Point>& right_hand_sides) const;
    /// The same in place for eight right-hand sides (V) side by side; `work` and `scratch` are
    /// overwritten.
    void solve(std::vector<Lanes<8>>& rows, std::vector<Lanes<8>>& work,
               std::vector<Lanes<8>>& scratch) const;

    /// Coordinates y (3 numbers per unknown) in which the matrix A = C Cᵀ is the identity: y = C⁻¹
    /// b of right-hand sides b (V), and x (V) = C⁻ᵀ y, 0 at the anchors.
    Eigen::VectorXd whitened(const std::vector<Point>& right_hand_sides) const;
    std::vector<Point> from_whitened(const Eigen::Ref<const Eigen::VectorXd>& y) const;

  private:
    std::vector<Lanes<4>> rows_of_unknowns(const std::vector<Point>& points) const;
    std::vector<Point> points_of_rows(const std::vector<Lanes<4>>& rows) const;

    std::vector<int> unknown_;  // (V) row of the system, -1 for the anchors
    int unknown_count_ = 0;
    std::optional<BlockCholesky> factor_;
};

}  // namespace mscomp
