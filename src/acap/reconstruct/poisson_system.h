// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anchored_system.h"
#include "linear_positions.h"
#include "mscomp/acap/edge_weights.h"
#include "mscomp/base/mesh_data.h"
#include "placement.h"

namespace mscomp {

/// The Poisson equation Σ_j c_ij (p'_i - p'_j) = ½ Σ_j c_ij (T_i + T_j)(p_i - p_j) of a reference,
/// its Laplacian factorised.
class PoissonSystem {
  public:
    PoissonSystem(const TriangleMesh& reference, EdgeWeights weights);

    /// (V) one for each coordinate of p'; `gradients` T (V).
    std::vector<Point> right_hand_sides(const std::vector<Eigen::Matrix3d>& gradients) const;

    int vertex_count() const { return rings_.vertex_count(); }
    const Placement& placement() const { return placement_; }
    const AnchoredSystem& system() const { return system_; }
    /// Borrows from this.
    LinearPositions positions() const { return {rings_, pulls_, system_, placement_}; }

  private:
    OneRings rings_;
    std::vector<double> weights_;  // c_ij beside rings_.neighbors
    std::vector<Point> reference_;
    std::vector<Eigen::Vector3d> pulls_;  // ½ c_vj (p_j - p_v), likewise
    Placement placement_;
    AnchoredSystem system_;
};

}  // namespace mscomp
