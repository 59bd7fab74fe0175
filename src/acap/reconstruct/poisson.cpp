// SPDX-License-Identifier: MIT
#include "acap/rotation.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/index.h"
#include "poisson_system.h"
#include "position_derivatives.h"

namespace mscomp {

struct PoissonReconstruction::State {
    State(const TriangleMesh& reference, EdgeWeights weights) : poisson(reference, weights) {}

    PoissonSystem poisson;
};

PoissonReconstruction::PoissonReconstruction(const TriangleMesh& reference, EdgeWeights weights)
    : state_(std::make_unique<State>(reference, weights)) {}
PoissonReconstruction::PoissonReconstruction(PoissonReconstruction&&) noexcept = default;
PoissonReconstruction& PoissonReconstruction::operator=(PoissonReconstruction&&) noexcept = default;
PoissonReconstruction::~PoissonReconstruction() = default;

std::vector<Point> PoissonReconstruction::solve(std::span<const float> features,
                                                std::span<const Point> like, Pieces pieces) const {
    const PoissonSystem& poisson = state_->poisson;
    const std::vector<Eigen::Matrix3d> gradients =
        gradients_of_features(features, at(poisson.vertex_count()));
    std::vector<Point> result = poisson.system().solve(poisson.right_hand_sides(gradients));
    if (like.empty() || pieces == Pieces::joined) {
        poisson.placement().join(gradients, like, result);
    } else {
        poisson.placement().apply(like, result);
    }
    return result;
}

void PoissonReconstruction::derivatives(std::span<const float> features,
                                        std::span<const FeatureDirection> directions,
                                        std::span<double> result) const {
    position_derivatives(state_->poisson.positions(), features, directions, result);
}

}  // namespace mscomp
