// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/index.h"

namespace mscomp {

using Point = std::array<double, 3>;
using Face = std::array<int, 3>;

/// Whether a vertex occurs twice.
inline bool is_degenerate(const Face& face) {
    return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

/// Points of V x 3 coordinates.
std::vector<Point> points_of(std::span<const float> coordinates);

/// One triangle mesh: V positions in the unit of its file and F faces (0-based, order as in the
/// file, polygons split). Plain data: every module may hold it, only acap/mesh reads and judges it.
struct TriangleMesh {
    std::vector<Point> vertices;
    std::vector<Face> faces;

    int vertex_count() const { return static_cast<int>(vertices.size()); }
    int face_count() const { return static_cast<int>(faces.size()); }
};

/// Neighbours of every vertex as compressed rows: those of i are neighbors[offsets[i] ..
/// offsets[i+1]), ascending, without i itself. Symmetric: j is a neighbour of i exactly if i is one
/// of j.
struct OneRings {
    std::vector<int> offsets{0};
    std::vector<int> neighbors;

    int vertex_count() const { return static_cast<int>(offsets.size()) - 1; }
    int degree(int vertex) const { return offsets[at(vertex) + 1] - offsets[at(vertex)]; }
};

/// One-rings of the edges of `faces` (any connectivity, non-manifold included).
OneRings one_rings_of_faces(int vertex_count, const std::vector<Face>& faces);

/// Connected component of every vertex, numbered from 0 in the order of their lowest vertex.
std::vector<int> connected_components(const OneRings& rings);

}  // namespace mscomp
