// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// The head that `generate face` moves, at rest: a bumpy ellipsoid, +y up, looking to +z, from the
/// chin at about y = -1 to the crown at 1. A closed manifold.
struct Head {
    TriangleMesh mesh;
    std::vector<Eigen::Vector3d> normal;  // (V)
};

/// The coarsest head with at least `vertices` vertices: an icosahedron whose edges are cut into
/// equal parts, made finer in front by a conformal map, so that triangles stay nearly equilateral.
Head head_with_vertices(int vertices);

}  // namespace mscomp
