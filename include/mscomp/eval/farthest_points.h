// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// `count` different vertices spread evenly over a shape, for handles: the first is the vertex
/// farthest from the centroid, each next one the vertex whose nearest chosen one is farthest away
/// (straight-line distance); of equals the lowest index. The first m of n samples are the m
/// samples. Throws UsageError unless 0 <= count <= V, MeshError where positions are not finite.
std::vector<int> farthest_point_samples(const std::vector<Point>& points, int count);

}  // namespace mscomp
