// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mscomp/acap/extract.h"
#include "mscomp/base/feature_set.h"

namespace mscomp {

/// Positions from features by the Poisson equation of method §2 (the papers' layer F): the
/// Laplacian of the reference, anchored once per connected component and factorised once, three
/// right-hand sides a shape. Approximate: the features of a mesh give back that mesh only nearly.
/// The anchor of each connected component is its centroid in the reference.
class PoissonReconstruction {
  public:
    PoissonReconstruction(const TriangleMesh& reference, EdgeWeights weights);
    PoissonReconstruction(PoissonReconstruction&&) noexcept;
    PoissonReconstruction& operator=(PoissonReconstruction&&) noexcept;
    ~PoissonReconstruction();

    /// `features` (V,9) unscaled -> (V) positions. Throws NumericalError on non-finite features.
    /// Safe to call from several threads.
    std::vector<Point> solve(std::span<const float> features) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mscomp
