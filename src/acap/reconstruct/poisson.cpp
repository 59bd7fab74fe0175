// SPDX-License-Identifier: MIT
#include "acap/edge_weights.h"
#include "acap/rotation.h"
#include "anchored_system.h"
#include "mscomp/acap/mesh/surface_mesh.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/index.h"
#include "placement.h"
#include "position_derivatives.h"

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

struct PoissonReconstruction::State {
    State(const TriangleMesh& mesh, EdgeWeights kind)
        : rings(SurfaceMesh(mesh).rings()),
          weights(edge_weights(mesh, rings, kind).weights),
          reference(mesh.vertices),
          pulls(pulls_of(rings, weights, reference)),
          placement(rings, reference),
          system(laplacian(rings, weights), mesh.vertex_count(), placement.first_vertices(),
                 "the Laplacian of the reference") {}

    std::vector<Point> right_hand_sides(const std::vector<Eigen::Matrix3d>& gradients) const;

    OneRings rings;
    std::vector<double> weights;  // beside rings.neighbors
    std::vector<Point> reference;
    std::vector<Eigen::Vector3d> pulls;  // likewise
    Placement placement;
    AnchoredSystem system;
};

/// Rows ½ Σ_j c_ij (T_i + T_j)(p_i - p_j), T_i taken out of the sum.
std::vector<Point> PoissonReconstruction::State::right_hand_sides(
    const std::vector<Eigen::Matrix3d>& gradients) const {
    std::vector<Point> rows(reference.size());
    for (std::size_t i = 0; i < reference.size(); ++i) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero(), edges = Eigen::Vector3d::Zero();
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const auto j = at(rings.neighbors[k]);
            const Eigen::Vector3d edge =
                0.5 * weights[k] * (as_vector(reference[i]) - as_vector(reference[j]));
            sum += gradients[j] * edge;
            edges += edge;
        }
        sum += gradients[i] * edges;
        Eigen::Map<Eigen::Vector3d>(rows[i].data()) = sum;
    }
    return rows;
}

PoissonReconstruction::PoissonReconstruction(const TriangleMesh& reference, EdgeWeights weights)
    : state_(std::make_unique<State>(reference, weights)) {}
PoissonReconstruction::PoissonReconstruction(PoissonReconstruction&&) noexcept = default;
PoissonReconstruction& PoissonReconstruction::operator=(PoissonReconstruction&&) noexcept = default;
PoissonReconstruction::~PoissonReconstruction() = default;

std::vector<Point> PoissonReconstruction::solve(std::span<const float> features,
                                                std::span<const Point> like, Pieces pieces) const {
    const std::vector<Eigen::Matrix3d> gradients =
        gradients_of_features(features, state_->reference.size());
    std::vector<Point> result = state_->system.solve(state_->right_hand_sides(gradients));
    if (like.empty() || pieces == Pieces::joined) {
        state_->placement.join(gradients, like, result);
    } else {
        state_->placement.apply(like, result);
    }
    return result;
}

void PoissonReconstruction::derivatives(std::span<const float> features,
                                        std::span<const FeatureDirection> directions,
                                        std::span<double> result) const {
    const LinearPositions positions{state_->rings, state_->pulls, state_->system,
                                    state_->placement};
    position_derivatives(positions, features, directions, result);
}

}  // namespace mscomp
