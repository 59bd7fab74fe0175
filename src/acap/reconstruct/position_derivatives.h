// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "linear_positions.h"
#include "mscomp/acap/reconstruct.h"

namespace mscomp {

/// Overwrites `result` (directions,V,3) with the derivatives of the positions at `features` (V,9)
/// along each direction. The same bits for any number of threads. Throws as gradients_of_features
/// does.
void position_derivatives(const LinearPositions& positions, std::span<const float> features,
                          std::span<const FeatureDirection> directions, std::span<double> result);

}  // namespace mscomp
