// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include "mscomp/geodesic/intrinsic_triangles.h"

namespace mscomp {

/// Adds to `divergence` (V, lanes), at every vertex and in every lane, the integrated divergence of
/// the unit field against the gradient of `heat` (V, lanes), for 1, 4 or 8 lanes. A lane's result
/// does not depend on the number of lanes.
void add_divergence(std::span<const FlatTriangle> triangles, const double* heat, double* divergence,
                    std::size_t lanes);

}  // namespace mscomp
