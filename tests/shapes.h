// SPDX-License-Identifier: MIT
// Meshes made in code, with known mathematics, for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp::shapes {

/// Cylinder around the z axis: rings of `around` vertices at `rings` heights from 0 to `length`;
/// closed by two caps (one centre vertex each, last two vertices) when `caps`.
inline TriangleMesh cylinder(int around, int rings, double radius, double length, bool caps) {
    TriangleMesh mesh;
    for (int ring = 0; ring < rings; ++ring) {
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around;
            mesh.vertices.push_back(
                {radius * std::cos(angle), radius * std::sin(angle), length * ring / (rings - 1)});
        }
    }
    const auto at = [&](int ring, int i) { return ring * around + i % around; };
    for (int ring = 0; ring + 1 < rings; ++ring) {
        for (int i = 0; i < around; ++i) {
            mesh.faces.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
            mesh.faces.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
        }
    }
    if (caps) {
        const int bottom = mesh.vertex_count();
        mesh.vertices.push_back({0, 0, 0});
        mesh.vertices.push_back({0, 0, length});
        for (int i = 0; i < around; ++i) {
            mesh.faces.push_back({bottom, at(0, i + 1), at(0, i)});
            mesh.faces.push_back({bottom + 1, at(rings - 1, i), at(rings - 1, i + 1)});
        }
    }
    return mesh;
}

/// Unit sphere: an icosahedron subdivided `levels` times (10 * 4^levels + 2 vertices).
inline TriangleMesh icosphere(int levels) {
    const double golden = (1 + std::sqrt(5.0)) / 2;
    TriangleMesh mesh;
    mesh.vertices = {{-1, golden, 0}, {1, golden, 0}, {-1, -golden, 0}, {1, -golden, 0},
                     {0, -1, golden}, {0, 1, golden}, {0, -1, -golden}, {0, 1, -golden},
                     {golden, 0, -1}, {golden, 0, 1}, {-golden, 0, -1}, {-golden, 0, 1}};
    mesh.faces = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                  {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                  {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                  {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    const auto to_sphere = [](Point p) {
        const double norm = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        return Point{p[0] / norm, p[1] / norm, p[2] / norm};
    };
    for (Point& p : mesh.vertices) p = to_sphere(p);
    for (int level = 0; level < levels; ++level) {
        std::map<std::array<int, 2>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [it, fresh] =
                middles.try_emplace({std::min(a, b), std::max(a, b)}, mesh.vertex_count());
            if (fresh) {
                const Point& p = mesh.vertices[static_cast<std::size_t>(a)];
                const Point& q = mesh.vertices[static_cast<std::size_t>(b)];
                mesh.vertices.push_back(to_sphere({p[0] + q[0], p[1] + q[1], p[2] + q[2]}));
            }
            return it->second;
        };
        std::vector<Face> finer;
        for (const auto& [a, b, c] : mesh.faces) {
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {Face{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        mesh.faces = std::move(finer);
    }
    return mesh;
}

/// Flat grid of columns x rows vertices, spacing 1, in the plane z = 0.
inline TriangleMesh grid(int columns, int rows) {
    TriangleMesh mesh;
    for (int y = 0; y < rows; ++y) {
        for (int x = 0; x < columns; ++x) {
            mesh.vertices.push_back({static_cast<double>(x), static_cast<double>(y), 0.0});
        }
    }
    for (int y = 0; y + 1 < rows; ++y) {
        for (int x = 0; x + 1 < columns; ++x) {
            const int a = y * columns + x;
            mesh.faces.push_back({a, a + 1, a + columns + 1});
            mesh.faces.push_back({a, a + columns + 1, a + columns});
        }
    }
    return mesh;
}

/// Both as one mesh, the second moved by `x` along the first axis.
inline TriangleMesh beside(TriangleMesh first, const TriangleMesh& second, double x) {
    const int count = first.vertex_count();
    for (const Face& f : second.faces) {
        first.faces.push_back({f[0] + count, f[1] + count, f[2] + count});
    }
    for (const Point& p : second.vertices) first.vertices.push_back({p[0] + x, p[1], p[2]});
    return first;
}

}  // namespace mscomp::shapes
