// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mscomp/acap/extract.h"
#include "occurrences.h"
#include "ring_normals.h"

namespace mscomp {

/// The map T_i of every vertex that takes its reference ring to the deformed one: the minimiser of
/// Σ_j c_ij |e'_ij - T e_ij|² + |h'_i n'_i - T h_i n_i|², i.e. A_i M_i^-1 (method §1). Everything
/// that depends on the reference alone is computed once.
class DeformationGradients {
  public:
    DeformationGradients(const TriangleMesh& reference, EdgeWeights weights);

    struct Result {
        std::vector<Eigen::Matrix3d> gradients;  // (V)
        Occurrences zero_area_faces;             // of the deformed shape
        Occurrences folded_rings;                // of the deformed shape
    };
    /// Gradients of one deformed shape (V positions). The identity at isolated vertices; the mean
    /// of the neighbours where the reference ring has no width (degenerate). Where the normals of
    /// a ring cancel their sign is the one that keeps orientation.
    Result compute(const std::vector<Point>& shape) const;

    const OneRings& rings() const { return rings_; }
    const std::vector<double>& weights() const { return weights_; }  // beside rings().neighbors
    const Occurrences& zero_area_faces() const { return zero_area_faces_; }
    const Occurrences& folded_rings() const { return normals_.folded_rings; }
    const Occurrences& isolated_vertices() const { return isolated_; }
    const Occurrences& degenerate_rings() const { return degenerate_; }

  private:
    void invert_moments();
    Eigen::Matrix3d ring_gradient(std::size_t vertex, const std::vector<Point>& shape,
                                  const RingNormals& normals) const;
    Eigen::Matrix3d mean_of_neighbors(std::size_t vertex,
                                      const std::vector<Eigen::Matrix3d>& gradients) const;

    TriangleMesh reference_;
    OneRings rings_;
    std::vector<double> weights_;
    RingNormals normals_;
    std::vector<Eigen::Matrix3d> inverse_moments_;  // (V) M_i^-1
    std::vector<char> usable_;                      // (V) M_i can be inverted
    Occurrences zero_area_faces_, isolated_, degenerate_;
};

}  // namespace mscomp
