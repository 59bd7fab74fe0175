// SPDX-License-Identifier: MIT
#include "poisson_system.h"

#include "acap/edge_weights.h"
#include "mscomp/acap/mesh/surface_mesh.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

MatrixEntries laplacian(const OneRings& rings, const std::vector<double>& weights) {
    MatrixEntries entries;
    add_laplacian(rings, weights, 1, entries);
    return entries;
}

/// What T_v adds to the right-hand side of its neighbour j: ½ c_vj (p_j - p_v).
std::vector<Eigen::Vector3d> pulls_of(const OneRings& rings, const std::vector<double>& weights,
                                      const std::vector<Point>& reference) {
    std::vector<Eigen::Vector3d> pulls(weights.size());
    for (std::size_t v = 0; v < reference.size(); ++v) {
        for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
            const auto k = at(place);
            const auto j = at(rings.neighbors[k]);
            pulls[k] = 0.5 * weights[k] * (as_vector(reference[j]) - as_vector(reference[v]));
        }
    }
    return pulls;
}

}  // namespace

PoissonSystem::PoissonSystem(const TriangleMesh& reference, EdgeWeights weights)
    : rings_(SurfaceMesh(reference).rings()),
      weights_(edge_weights(reference, rings_, weights).weights),
      reference_(reference.vertices),
      pulls_(pulls_of(rings_, weights_, reference_)),
      placement_(rings_, reference_),
      system_(laplacian(rings_, weights_), reference.vertex_count(), placement_.first_vertices(),
              "the Laplacian of the reference") {}

/// Rows ½ Σ_j c_ij (T_i + T_j)(p_i - p_j), T_i taken out of the sum.
std::vector<Point> PoissonSystem::right_hand_sides(
    const std::vector<Eigen::Matrix3d>& gradients) const {
    std::vector<Point> rows(reference_.size());
    for (std::size_t i = 0; i < reference_.size(); ++i) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero(), edges = Eigen::Vector3d::Zero();
        for (int place = rings_.offsets[i]; place < rings_.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const auto j = at(rings_.neighbors[k]);
            const Eigen::Vector3d edge =
                0.5 * weights_[k] * (as_vector(reference_[i]) - as_vector(reference_[j]));
            sum += gradients[j] * edge;
            edges += edge;
        }
        sum += gradients[i] * edges;
        Eigen::Map<Eigen::Vector3d>(rows[i].data()) = sum;
    }
    return rows;
}

}  // namespace mscomp
