// SPDX-License-Identifier: MIT
// Bodies that are their own mirror images, for tests.
#pragma once

#include "acap_cases.h"
#include "mscomp/acap/mirror.h"

namespace mscomp::cases {

/// Symmetric under x → -x and no other reflection.
inline Vector3d two_sided(const Vector3d& p) {
    return {p.x() * (1 + 0.2 * p.y()), 1.7 * p.y() + 0.3 * p.z() * p.z() + 0.4 * p.x() * p.x(),
            1.25 * p.z() + 0.2 * p.y() * p.y()};
}

/// two_sided() of a sphere whose vertices and faces are mirror images of each other.
inline TriangleMesh two_sided_body(int levels) {
    return mapped(shapes::icosphere(levels), two_sided);
}

/// The same surface, with vertices that are not.
inline TriangleMesh two_sided_body_askew(int levels) {
    return mapped(shapes::icosphere(levels), [](const Vector3d& p) -> Vector3d {
        return two_sided(rotation_about({1, 2, 3}, 0.7) * p);
    });
}

inline Matrix3d flipped_x() { return Vector3d(-1, 1, 1).asDiagonal(); }

inline Vector3d located(const TriangleMesh& mesh, const SurfaceLocation& location) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
        sum +=
            static_cast<double>(location.weights[k]) * vec(mesh.vertices[at(location.corners[k])]);
    }
    return sum;
}

/// Of every vertex the one that lies nearest to (-x, y, z).
inline std::vector<int> opposite_vertices(const TriangleMesh& mesh) {
    std::vector<int> result;
    for (const Point& p : mesh.vertices) {
        const Vector3d image = flipped_x() * vec(p);
        const auto nearest = std::ranges::min_element(
            mesh.vertices, {}, [&](const Point& q) { return (vec(q) - image).squaredNorm(); });
        result.push_back(static_cast<int>(nearest - mesh.vertices.begin()));
    }
    return result;
}

/// The corner that counts most.
inline int main_corner(const SurfaceLocation& location) {
    return location
        .corners[at(std::ranges::max_element(location.weights) - location.weights.begin())];
}

}  // namespace mscomp::cases
