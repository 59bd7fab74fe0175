// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Sizes of meshes that keep fewer than five digits of their shape in float32 when they lie further
/// away from the origin.
constexpr double kFarFromOrigin = 100;

/// Largest absolute coordinate divided by the longest side of the bounding box; 0 where that side
/// is.
double distance_from_origin(const std::vector<Point>& shape);

/// Whether `shape` has a size, but one whose positions are 0 or lose digits in float32.
bool is_too_small_for_float(const std::vector<Point>& shape);

}  // namespace mscomp
