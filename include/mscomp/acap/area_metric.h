// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Roots s_v (V) of what the squared error of a feature counts at each vertex: its area, a third of
/// that of its triangles, as a multiple of the mean, at least 0.02, then 1 on average again. Many
/// small triangles (lids, lips) then weigh no more than the surface that they cover.
std::vector<float> area_metric(const TriangleMesh& mesh);

}  // namespace mscomp
