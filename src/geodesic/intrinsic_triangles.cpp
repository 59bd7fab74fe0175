// SPDX-License-Identifier: MIT
#include "mscomp/geodesic/intrinsic_triangles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "intrinsic_delaunay.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// How far, in mean edge lengths, two edges of a triangle together have to exceed the third.
constexpr double kMargin = 1e-5;

const Point& corner_of(const TriangleMesh& mesh, int vertex) { return mesh.vertices[at(vertex)]; }

double distance(const Point& p, const Point& q) {
    return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

void check_mesh(const TriangleMesh& mesh) {
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        const Point& p = corner_of(mesh, i);
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
            throw MeshError(
                fmt::format("geodesics: vertex {} is ({}, {}, {}), wanted finite numbers", i, p[0],
                            p[1], p[2]));
        }
    }
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        for (const int vertex : mesh.faces[f]) {
            if (vertex < 0 || vertex >= mesh.vertex_count()) {
                throw MeshError(
                    fmt::format("geodesics: face {} refers to vertex {}, the mesh has {} vertices",
                                f, vertex, mesh.vertex_count()));
            }
        }
    }
}

std::vector<Face> faces_with_three_corners(const std::vector<Face>& faces) {
    std::vector<Face> kept;
    kept.reserve(faces.size());
    for (const Face& face : faces) {
        if (face[0] != face[1] && face[1] != face[2] && face[2] != face[0]) kept.push_back(face);
    }
    return kept;
}

double mean_edge_length(const TriangleMesh& mesh, const OneRings& rings) {
    double sum = 0;
    std::size_t count = 0;
    for (int i = 0; i < rings.vertex_count(); ++i) {
        const auto row = at(i);
        for (int k = rings.offsets[row]; k < rings.offsets[row + 1]; ++k) {
            const int j = rings.neighbors[at(k)];
            if (j < i) continue;
            sum += distance(corner_of(mesh, i), corner_of(mesh, j));
            ++count;
        }
    }
    return count == 0 ? 0 : sum / static_cast<double>(count);
}

EdgeLengths longest_edge_first(const EdgeLengths& face) {
    const auto longest =
        at(std::max_element(face.lengths.begin(), face.lengths.end()) - face.lengths.begin());
    EdgeLengths turned;
    for (std::size_t k = 0; k < 3; ++k) {
        turned.corners[k] = face.corners[(k + longest) % 3];
        turned.lengths[k] = face.lengths[(k + longest) % 3];
    }
    return turned;
}

FlatTriangle lay_flat(const EdgeLengths& face) {
    const EdgeLengths turned = longest_edge_first(face);
    const auto& [base, right, left] = turned.lengths;
    FlatTriangle flat;
    flat.corners = turned.corners;
    flat.base = base;
    flat.x = std::clamp(0.5 * (base + (left - right) * (left + right) / base), 0.0, base);
    flat.y = 2 * area_of(turned.lengths) / base;
    return flat;
}

/// The length that, added to every edge, makes every triangle exceed its longest edge by kMargin.
double mollification(const std::vector<EdgeLengths>& faces) {
    double missing = 0;
    for (const EdgeLengths& face : faces) {
        const auto& [a, b, c] = face.lengths;
        const double slack = a + b + c - 2 * std::max({a, b, c});
        missing = std::max(missing, kMargin - slack);
    }
    return missing;
}

}  // namespace

IntrinsicTriangles intrinsic_triangles(const TriangleMesh& mesh) {
    check_mesh(mesh);
    const std::vector<Face> faces = faces_with_three_corners(mesh.faces);
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), faces);
    IntrinsicTriangles surface;
    surface.vertex_count = mesh.vertex_count();
    surface.component = connected_components(rings);
    surface.mean_edge_length = mean_edge_length(mesh, rings);
    if (!(surface.mean_edge_length > 0)) return surface;

    std::vector<EdgeLengths> edges;
    edges.reserve(faces.size());
    for (const Face& face : faces) {
        EdgeLengths& one = edges.emplace_back();
        one.corners = face;
        for (std::size_t k = 0; k < 3; ++k) {
            one.lengths[k] =
                distance(corner_of(mesh, face[k]), corner_of(mesh, face[(k + 1) % 3])) /
                surface.mean_edge_length;
        }
    }
    surface.added_length = mollification(edges);
    for (EdgeLengths& face : edges) {
        for (double& length : face.lengths) length += surface.added_length;
    }
    surface.flips = make_intrinsic_delaunay(edges);
    surface.triangles.reserve(edges.size());
    for (const EdgeLengths& face : edges) surface.triangles.push_back(lay_flat(face));
    return surface;
}

std::vector<double> apply_laplacian(const IntrinsicTriangles& surface, std::span<const double> x) {
    std::vector<double> result(at(surface.vertex_count), 0.0);
    for (const FlatTriangle& triangle : surface.triangles) {
        const std::array<double, 3> cotangents = triangle.cotangents();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = at(triangle.corners[(k + 1) % 3]);
            const auto j = at(triangle.corners[(k + 2) % 3]);
            const double flow = 0.5 * cotangents[k] * (x[i] - x[j]);
            result[i] += flow;
            result[j] -= flow;
        }
    }
    return result;
}

std::vector<double> lumped_mass(const IntrinsicTriangles& surface) {
    std::vector<double> mass(at(surface.vertex_count), 0.0);
    for (const FlatTriangle& triangle : surface.triangles) {
        for (const int vertex : triangle.corners) {
            mass[at(vertex)] += triangle.area() / 3;
        }
    }
    return mass;
}

}  // namespace mscomp
