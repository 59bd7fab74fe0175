// SPDX-License-Identifier: MIT
// Meshes whose vertices lie on each other, for tests.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "shapes.h"

namespace mscomp::shapes {

/// cylinder() without caps, cut open along a UV seam: every ring has one vertex more, which lies on
/// its first one but for rounding.
inline TriangleMesh seamed_tube(int around, int rings, double radius, double length) {
    TriangleMesh mesh;
    for (int ring = 0; ring < rings; ++ring) {
        for (int i = 0; i <= around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around;
            mesh.vertices.push_back(
                {radius * std::cos(angle), radius * std::sin(angle), length * ring / (rings - 1)});
        }
    }
    const auto at = [&](int ring, int i) { return ring * (around + 1) + i; };
    for (int ring = 0; ring + 1 < rings; ++ring) {
        for (int i = 0; i < around; ++i) {
            mesh.faces.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
            mesh.faces.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
        }
    }
    return mesh;
}

/// The same faces, each with three vertices of its own.
inline TriangleMesh soup(const TriangleMesh& mesh) {
    TriangleMesh result;
    for (const Face& face : mesh.faces) {
        const int first = result.vertex_count();
        for (const int corner : face) {
            result.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)]);
        }
        result.faces.push_back({first, first + 1, first + 2});
    }
    return result;
}

}  // namespace mscomp::shapes
