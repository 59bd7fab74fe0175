// SPDX-License-Identifier: MIT
#pragma once

#include "feature_equations.h"
#include "linear_positions.h"
#include "placement.h"
#include "tangential_solve.h"

namespace mscomp {

/// The feature equations of a reference and the linear ones among them, factorised.
struct TangentialSystem {
    TangentialSystem(const TriangleMesh& reference, EdgeWeights weights)
        : equations(reference, weights),
          placement(equations.gradients().rings(), reference.vertices),
          tangential(equations, placement.first_vertices()) {}
    TangentialSystem(const TangentialSystem&) = delete;
    TangentialSystem& operator=(const TangentialSystem&) = delete;

    /// Borrows from this.
    LinearPositions positions() const {
        return {equations.gradients().rings(), tangential.pulls(), tangential.system(), placement};
    }

    FeatureEquations equations;
    Placement placement;
    TangentialSolve tangential;
};

}  // namespace mscomp
