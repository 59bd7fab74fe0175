// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "feature_equations.h"
#include "mscomp/acap/reconstruct.h"

namespace mscomp {

/// Goes on from result.vertices to the minimum of the equations' energy plus that of the soft
/// handles by Levenberg-Marquardt steps of Ceres, one residual block per vertex; hard handles and
/// the vertices `held` do not move. `wanted` as FeatureEquations::wanted. Sets vertices, steps and
/// converged. Throws NumericalError if Ceres fails.
void refine_by_ceres(const FeatureEquations& equations, const std::vector<Eigen::Matrix3d>& wanted,
                     std::span<const Handle> handles, std::span<const int> held,
                     ReconstructedShape& result);

}  // namespace mscomp
