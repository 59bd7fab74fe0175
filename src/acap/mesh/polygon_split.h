// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"
#include "polygon_mesh.h"

namespace mscomp {

/// The triangles of polygons.
struct SplitFaces {
    std::vector<Face> faces;        // (F) polygon by polygon
    std::vector<int> face_numbers;  // (F) of the polygon in its file, from 1
};

/// Splits the polygons of `mesh` along inner diagonals, as seen in the plane in which each has its
/// largest area, with the `positions` (V) of the reference. Triangles stay as they are. A convex
/// polygon becomes the fan of its corner with the lowest number; of any other, ears are cut off,
/// those beside the lowest number first. So the corner a polygon begins with and the direction it
/// is read in change nothing. What has no inner diagonal (no area, a contour that crosses itself)
/// becomes a fan as well.
SplitFaces split_into_triangles(const PolygonMesh& mesh, const std::vector<Point>& positions);

}  // namespace mscomp
