// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "anchored_system.h"
#include "feature_equations.h"

namespace mscomp {

/// The part of the feature equations that leaves the pseudo-edges out, r_i P_i = 0, is linear:
/// Σ_j e'_ij (P_i g_ij)ᵀ = T_i M_i^½ P_i, twice as many equations as unknowns, with a constant
/// matrix. A mesh fulfils all equations of its own features, hence these: their least-squares
/// solution gives the mesh back, in one solve. Borrows the equations.
class TangentialSolve {
  public:
    TangentialSolve(const FeatureEquations& equations, const std::vector<int>& anchors);

    /// Moves `shape` (V) to the least-squares solution; the anchors stay.
    void apply(const std::vector<Eigen::Matrix3d>& wanted, std::vector<Point>& shape) const;

    /// sqrt(Σ |r_i P_i|² / Σ |T_i M_i^½ P_i|²) of a shape; 0 for features without size.
    double residual(const std::vector<Eigen::Matrix3d>& wanted,
                    const std::vector<Point>& shape) const;

    /// What T_v adds to the right-hand side of its neighbour j is T_v times this, M_v^½ P_v g_vj.
    const std::vector<Eigen::Vector3d>& pulls() const { return pulls_; }

    /// Has nearly the pattern of all systems on two rings.
    const AnchoredSystem& system() const { return system_; }

  private:
    Eigen::Matrix3d missing(std::size_t vertex, const std::vector<Eigen::Matrix3d>& wanted,
                            const std::vector<Point>& shape) const;
    std::vector<Point> descent(const std::vector<Eigen::Matrix3d>& wanted,
                               const std::vector<Point>& shape) const;

    const FeatureEquations& equations_;
    std::vector<Eigen::Vector3d> factors_;  // P_i g_ij beside the rings' neighbours
    std::vector<Eigen::Vector3d> pulls_;    // likewise
    AnchoredSystem system_;
};

}  // namespace mscomp
