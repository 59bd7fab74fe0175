// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "anchored_system.h"
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

    std::size_t vertex_count() const { return placement.component().size(); }
};

}  // namespace mscomp
