// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acap/deformation_gradient.h"

namespace mscomp {

/// Σ |T_i M_i^½|² of FeatureEquations::wanted.
double squared_size(const std::vector<Eigen::Matrix3d>& wanted);

/// The equations that say "these positions have these features" (method §2, lossless): at every
/// vertex the nine residuals r_i = (A_i(p') M_i^-1 - T_i) M_i^½, with A_i as in extraction. Written
/// out, r_i = Σ_j e'_ij g_ijᵀ + h'_i n'_i g_iᵀ - T_i M_i^½ with constant g_ij = c_ij M_i^-½ e_ij
/// and g_i = h_i M_i^-½ n_i: only the pseudo-edge h'_i n'_i is not linear in p'. Vertices without a
/// usable ring have no equations.
class FeatureEquations {
  public:
    FeatureEquations(const TriangleMesh& reference, EdgeWeights weights);

    const DeformationGradients& gradients() const { return gradients_; }
    /// g_ij beside gradients().rings().neighbors.
    const std::vector<Eigen::Vector3d>& edge_factors() const { return edge_factors_; }
    /// g_i (V).
    const std::vector<Eigen::Vector3d>& normal_factors() const { return normal_factors_; }

    /// T_i M_i^½ (V), the constant part of the residuals; zero without equations.
    std::vector<Eigen::Matrix3d> wanted(const std::vector<Eigen::Matrix3d>& gradients) const;

    /// Projections (V) that take the residuals to the part without the pseudo-edge: r_i P_i is
    /// linear in p', with the factors P_i g_ij.
    const std::vector<Eigen::Matrix3d>& tangential() const { return tangential_; }

    /// Σ_i |r_i|² at `shape` (V), and its derivative (V) by the positions. Where the normals of a
    /// ring cancel, the direction of its pseudo-edge counts as constant in the derivative.
    double energy(const std::vector<Point>& shape, const std::vector<Eigen::Matrix3d>& wanted,
                  std::vector<Point>& derivative) const;

  private:
    Eigen::Matrix3d residual(std::size_t vertex, const std::vector<Point>& shape,
                             const RingNormals& normals,
                             const std::vector<Eigen::Matrix3d>& wanted) const;
    void add_pseudo_edge_derivative(const std::vector<Point>& shape, const RingNormals& normals,
                                    const std::vector<Eigen::Vector3d>& by_pseudo_edge,
                                    std::vector<Point>& derivative) const;

    DeformationGradients gradients_;
    std::vector<Eigen::Vector3d> edge_factors_;
    std::vector<Eigen::Vector3d> normal_factors_;
    std::vector<Eigen::Matrix3d> root_moments_;  // (V) M_i^½
    std::vector<Eigen::Matrix3d> tangential_;
};

}  // namespace mscomp
