// SPDX-License-Identifier: MIT
#include "head.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "limb.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::Vector3d;

// ---------------------------------------------------------------------------------------------
// The sphere.

const std::array<Vector3d, 12>& icosahedron() {
    static const std::array<Vector3d, 12> corners = [] {
        const double g = (1 + std::sqrt(5.0)) / 2;
        return std::array<Vector3d, 12>{{{-1, g, 0},
                                         {1, g, 0},
                                         {-1, -g, 0},
                                         {1, -g, 0},
                                         {0, -1, g},
                                         {0, 1, g},
                                         {0, -1, -g},
                                         {0, 1, -g},
                                         {g, 0, -1},
                                         {g, 0, 1},
                                         {-g, 0, -1},
                                         {-g, 0, 1}}};
    }();
    return corners;
}

/// All triples of mutually nearest corners, turned outwards.
std::vector<Face> icosahedron_faces() {
    const auto& p = icosahedron();
    const auto near = [&p](std::size_t a, std::size_t b) { return (p[a] - p[b]).norm() < 2.1; };
    std::vector<Face> faces;
    for (std::size_t a = 0; a < 12; ++a) {
        for (std::size_t b = a + 1; b < 12; ++b) {
            for (std::size_t c = b + 1; c < 12; ++c) {
                if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
                const Face face{static_cast<int>(a), static_cast<int>(b), static_cast<int>(c)};
                const bool outwards = p[a].dot(p[b].cross(p[c])) > 0;
                faces.push_back(outwards ? face : Face{face[0], face[2], face[1]});
            }
        }
    }
    return faces;
}

/// 10 parts^2 + 2 vertices on the unit sphere.
TriangleMesh sphere(int parts) {
    TriangleMesh mesh;
    // A vertex is known by how much of which corners it is made of.
    std::map<std::vector<std::array<int, 2>>, int> known;
    const auto vertex = [&](const Face& face, int b, int c) {
        const std::array<int, 3> share{parts - b - c, b, c};
        std::vector<std::array<int, 2>> key;
        Vector3d sum = Vector3d::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            if (share[k] > 0) key.push_back({face[k], share[k]});
        }
        std::ranges::sort(key);
        for (const auto& [corner, parts_of_it] : key) {
            sum += parts_of_it * icosahedron()[at(corner)];
        }
        const auto [place, fresh] = known.try_emplace(std::move(key), mesh.vertex_count());
        if (fresh) {
            sum.normalize();
            mesh.vertices.push_back({sum[0], sum[1], sum[2]});
        }
        return place->second;
    };
    for (const Face& face : icosahedron_faces()) {
        for (int b = 0; b < parts; ++b) {
            for (int c = 0; b + c < parts; ++c) {
                mesh.faces.push_back(
                    {vertex(face, b, c), vertex(face, b + 1, c), vertex(face, b, c + 1)});
                if (b + c + 1 == parts) continue;
                mesh.faces.push_back(
                    {vertex(face, b + 1, c), vertex(face, b + 1, c + 1), vertex(face, b, c + 1)});
            }
        }
    }
    return mesh;
}

/// Conformal map of the sphere to itself that draws it together around +z: stereographic
/// projection from -z, scaled.
Vector3d drawn_to_front(const Vector3d& p) {
    constexpr double scale = 0.62;
    const double x = scale * p[0] / (1 + p[2]), y = scale * p[1] / (1 + p[2]);
    if (!std::isfinite(x + y)) return -Vector3d::UnitZ();
    const double square = x * x + y * y;
    return Vector3d(2 * x, 2 * y, 1 - square) / (1 + square);
}

// ---------------------------------------------------------------------------------------------
// The head.

/// A smooth bump of the front.
struct Bump {
    double x, y, half_width, half_height;
    double forwards, sidewards;
};

/// Both sides where x is not 0.
const std::vector<Bump>& bumps() {
    static const std::vector<Bump> all{{0.00, 0.16, 0.075, 0.17, 0.10, 0},     // bridge of the nose
                                       {0.00, -0.02, 0.085, 0.11, 0.17, 0},    // its tip
                                       {0.09, -0.05, 0.055, 0.055, 0.06, 0},   // its wings
                                       {0.27, 0.36, 0.19, 0.065, 0.065, 0},    // brows
                                       {0.27, 0.18, 0.16, 0.10, -0.10, 0},     // sockets
                                       {0.26, 0.17, 0.085, 0.065, 0.075, 0},   // eyes
                                       {0.40, -0.06, 0.17, 0.15, 0.05, 0.02},  // cheeks
                                       {0.00, -0.275, 0.17, 0.05, 0.045, 0},   // upper lip
                                       {0.00, -0.355, 0.19, 0.036, -0.022, 0},  // mouth
                                       {0.00, -0.43, 0.14, 0.052, 0.05, 0},     // lower lip
                                       {0.00, -0.53, 0.16, 0.05, -0.03, 0},     // below it
                                       {0.00, -0.72, 0.18, 0.12, 0.09, 0}};     // chin
    return all;
}

double bell(double x) { return std::exp(-x * x); }

/// Where the direction d of the sphere lies on the head.
Vector3d head_point(const Vector3d& d) {
    const double down = smooth_step(-d[1], 0.0, 1.0), back = smooth_step(-d[2], -0.3, 0.9);
    // Narrower jaw, flat back of the head: wider than deep.
    Vector3d p(0.8 * d[0] * (1 - 0.28 * down), d[1] + 0.06 * back * (1 - d[1] * d[1]),
               (d[2] > 0 ? 0.66 : 0.5) * d[2] * (1 - 0.12 * down * back));
    const double front = smooth_step(d[2], 0.0, 0.5);
    const Vector3d rest = p;
    for (const Bump& bump : bumps()) {
        for (const double side : {-1.0, 1.0}) {
            if (bump.x == 0 && side < 0) continue;
            const double amount = front * bell((rest[0] - side * bump.x) / bump.half_width) *
                                  bell((rest[1] - bump.y) / bump.half_height);
            p += amount * Vector3d(side * bump.sidewards, 0, bump.forwards);
        }
    }
    for (const double side : {-1.0, 1.0}) {  // ears
        const double amount = bell((rest[1] - 0.08) / 0.16) * bell((rest[2] + 0.02) / 0.07) *
                              smooth_step(side * d[0], 0.3, 0.8);
        p += amount * Vector3d(side * 0.08, 0, -0.03);
    }
    return p;
}

}  // namespace

Head head_with_vertices(int vertices) {
    const int parts = static_cast<int>(std::ceil(std::sqrt((vertices - 2) / 10.0)));
    Head head{sphere(parts), {}};
    for (Point& p : head.mesh.vertices) {
        Eigen::Map<Vector3d> place(p.data());
        place = head_point(drawn_to_front(place));
    }
    head.normal = vertex_normals(head.mesh);
    return head;
}

}  // namespace mscomp
