// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "anchored_system.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/mesh_data.h"
#include "placement.h"

namespace mscomp {

/// Positions that depend linearly on the deformation gradients: A p' = Σ_v of what T_v adds to the
/// right-hand sides of its ring, T_v q_vj to that of each neighbour j and minus their sum to its
/// own, the connected components then joined and the whole moved to a centroid. Borrows everything.
struct LinearPositions {
    const OneRings& rings;
    const std::vector<Eigen::Vector3d>& pulls;  // q_vj beside rings.neighbors
    const AnchoredSystem& system;
    const Placement& placement;
};

/// Overwrites `result` (directions,V,3) with the derivatives of the positions at `features` (V,9)
/// along each direction. The same bits for any number of threads. Throws as gradients_of_features
/// does.
void position_derivatives(const LinearPositions& positions, std::span<const float> features,
                          std::span<const FeatureDirection> directions, std::span<double> result);

}  // namespace mscomp
