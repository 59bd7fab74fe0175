// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/acap/mesh/surface_mesh.h"
#include "mscomp/base/index.h"
#include "occurrences.h"
#include "ring_normals.h"

namespace mscomp {

/// Whether `image` rather than -image is where the pseudo-edge along `normal` goes if A + image
/// normalᵀ, A the moment of the edges of a ring, shall keep orientation: det(A + s w nᵀ) = det A +
/// s nᵀ adj(A) w, and the right sign is the one with the larger value.
bool keeps_orientation(const Eigen::Matrix3d& edge_moment, const Eigen::Vector3d& normal,
                       const Eigen::Vector3d& image);

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

    /// Normals of one deformed shape with the signs that compute() takes, without heights.
    RingNormals directions(const std::vector<Point>& shape) const;
    /// compute() for the vertices from `first` on, as many as there are `gradients`; `directions`
    /// are those of `shape`. Nothing is allocated.
    void compute(const std::vector<Point>& shape, const RingNormals& directions, std::size_t first,
                 std::span<Eigen::Matrix3d> gradients) const;

    /// Pseudo-edges of one deformed shape; where the normals of a ring cancel, with the sign that
    /// keeps orientation.
    RingNormals pseudo_edges(const std::vector<Point>& shape) const;

    const TriangleMesh& reference() const { return reference_; }
    const RingNormals& reference_pseudo_edges() const { return normals_; }
    /// M_i^-1 (V); zero where has_gradient says no.
    const std::vector<Eigen::Matrix3d>& inverse_moments() const { return inverse_moments_; }
    bool has_gradient(int vertex) const { return usable_[at(vertex)] != 0; }

    const SurfaceMesh& mesh() const { return mesh_; }
    const OneRings& rings() const { return mesh_.rings(); }
    const std::vector<double>& weights() const { return weights_; }  // beside rings().neighbors
    const Occurrences& zero_area_faces() const { return zero_area_faces_; }
    const Occurrences& folded_rings() const { return normals_.folded_rings; }
    const Occurrences& isolated_vertices() const { return isolated_; }
    const Occurrences& degenerate_rings() const { return degenerate_; }

  private:
    void invert_moments();
    void prepare_duals();
    /// Σ_j c_ij e'_ij e_ijᵀ.
    Eigen::Matrix3d edge_moment(std::size_t vertex, const std::vector<Point>& shape) const;
    void choose_signs(const std::vector<Point>& shape, RingNormals& normals) const;
    Eigen::Matrix3d ring_gradient(std::size_t vertex, const std::vector<Point>& shape,
                                  const RingNormals& directions) const;
    Eigen::Matrix3d mean_of_neighbors(std::size_t vertex, const std::vector<Point>& shape,
                                      const RingNormals& directions) const;

    TriangleMesh reference_;
    SurfaceMesh mesh_;
    std::vector<double> weights_;
    RingNormals normals_;
    std::vector<Eigen::Matrix3d> inverse_moments_;  // (V) M_i^-1
    std::vector<char> usable_;                      // (V) M_i can be inverted
    // What T_i is a sum of: T_i = Σ_j e'_ij (M_i^-1 c_ij e_ij)ᵀ + h'_i n'_i (M_i^-1 h_i n_i)ᵀ.
    std::vector<Eigen::Vector3d> edge_duals_;    // M_i^-1 c_ij e_ij beside rings().neighbors
    std::vector<Eigen::Vector3d> normal_duals_;  // (V) M_i^-1 h_i n_i
    Occurrences zero_area_faces_, isolated_, degenerate_;
};

}  // namespace mscomp
