// SPDX-License-Identifier: MIT
#include "mscomp/geodesic/intrinsic_triangles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "mscomp/base/error.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

/// A flat grid sheared so far that many angles are obtuse and many cotangents negative.
TriangleMesh sheared_grid(int columns, int rows) {
    TriangleMesh mesh = shapes::grid(columns, rows);
    for (Point& p : mesh.vertices) p = {p[0] + 0.8 * p[1] + 0.1 * std::sin(p[0]), p[1], 0};
    return mesh;
}

double surface_area(const TriangleMesh& mesh) {
    double area = 0;
    for (const Face& face : mesh.faces) {
        const Point& p = mesh.vertices[static_cast<std::size_t>(face[0])];
        const Point& q = mesh.vertices[static_cast<std::size_t>(face[1])];
        const Point& r = mesh.vertices[static_cast<std::size_t>(face[2])];
        const Point u{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
        const Point v{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
        area += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                                 u[0] * v[1] - u[1] * v[0]);
    }
    return area;
}

/// A sphere pressed and drawn out to a blade: obtuse triangles on a curved surface.
TriangleMesh blade(int levels, double length, double thickness) {
    TriangleMesh mesh = shapes::icosphere(levels);
    for (Point& p : mesh.vertices) p = {length * p[0], p[1], thickness * p[2]};
    return mesh;
}

/// Two crumpled fans of `count` vertices, sewn together along the rim: with few vertices and long
/// needles, flipped triangles come to neighbour themselves.
TriangleMesh pillow(int count, std::uint64_t seed) {
    const CounterRandom random(seed, 1);
    TriangleMesh mesh;
    for (int i = 0; i < count; ++i) {
        const auto at = static_cast<std::uint64_t>(3 * i);
        mesh.vertices.push_back(
            {10 * random.uniform(at), random.uniform(at + 1), 0.1 * random.uniform(at + 2)});
    }
    const int last = count - 1;
    for (int i = 1; i < last; ++i) {
        mesh.faces.push_back({0, i, i + 1});
        mesh.faces.push_back({last, i, i - 1});
    }
    return mesh;
}

/// Without those flat enough to be opened by mollification.
std::vector<TriangleMesh> obtuse_meshes() {
    std::vector<TriangleMesh> meshes{blade(2, 3, 0.1), blade(1, 20, 0.01)};
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        const TriangleMesh mesh = pillow(4 + static_cast<int>(seed % 5), seed);
        if (intrinsic_triangles(mesh).added_length == 0) meshes.push_back(mesh);
    }
    return meshes;
}

/// (V) sum of the angles of all triangles at each vertex.
std::vector<double> angle_sums(const IntrinsicTriangles& surface) {
    std::vector<double> sums(static_cast<std::size_t>(surface.vertex_count), 0.0);
    for (const FlatTriangle& triangle : surface.triangles) {
        const std::array<double, 3> cotangents = triangle.cotangents();
        for (std::size_t k = 0; k < 3; ++k) {
            sums[static_cast<std::size_t>(triangle.corners[k])] += std::atan2(1, cotangents[k]);
        }
    }
    return sums;
}

double angle_at(const Point& p, const Point& q, const Point& r) {
    const Point u{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    const Point v{r[0] - p[0], r[1] - p[1], r[2] - p[2]};
    const double dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    return std::acos(dot / (std::hypot(u[0], u[1], u[2]) * std::hypot(v[0], v[1], v[2])));
}

double total(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

// Linear precision: L x = 0 inside a flat mesh for every linear x, flipped edges included.
TEST(Laplacian, VanishesOnLinearFunctionsInsideAFlatMesh) {
    const int columns = 12, rows = 9;
    const TriangleMesh mesh = sheared_grid(columns, rows);
    const IntrinsicTriangles surface = intrinsic_triangles(mesh);
    ASSERT_GT(surface.flips, 0);
    std::vector<double> x;
    for (const Point& p : mesh.vertices) x.push_back(3 * p[0] - 2 * p[1] + 5);
    const std::vector<double> result = apply_laplacian(surface, x);
    for (int row = 1; row + 1 < rows; ++row) {
        for (int column = 1; column + 1 < columns; ++column) {
            const auto i = static_cast<std::size_t>(row * columns + column);
            EXPECT_LE(std::abs(result[i]), 1e-11) << "vertex " << i;
        }
    }
}

// x^T L x of a linear function is |gradient|^2 times the area.
TEST(Laplacian, EnergyOfALinearFunctionIsAreaTimesSquaredSlope) {
    const TriangleMesh mesh = sheared_grid(12, 9);
    const IntrinsicTriangles surface = intrinsic_triangles(mesh);
    std::vector<double> x;
    for (const Point& p : mesh.vertices) x.push_back(3 * p[0] - 2 * p[1]);
    const std::vector<double> Lx = apply_laplacian(surface, x);
    const double energy = std::inner_product(x.begin(), x.end(), Lx.begin(), 0.0);
    double area = 0;
    for (const FlatTriangle& triangle : surface.triangles) area += triangle.area();
    const double unit = surface.mean_edge_length;
    EXPECT_NEAR(energy / (13 * area * unit * unit), 1, 1e-12);
}

// Green: constants are in the kernel and the range is orthogonal to constants.
TEST(Laplacian, KnowsNoConstants) {
    const IntrinsicTriangles surface = intrinsic_triangles(shapes::icosphere(2));
    const CounterRandom random(1, 0);
    std::vector<double> ones(162, 1.0), x(162);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = random.normal(i);
    for (const double entry : apply_laplacian(surface, ones)) EXPECT_EQ(entry, 0.0);
    EXPECT_NEAR(total(apply_laplacian(surface, x)), 0, 1e-12);
}

// The energy is >= 0 for any x, obtuse and zero-area faces included.
TEST(Laplacian, IsPositiveSemidefiniteOnBadMeshes) {
    TriangleMesh mesh = sheared_grid(8, 8);
    for (std::size_t i = 0; i < 8; ++i) mesh.vertices[8 + i] = mesh.vertices[i];
    const IntrinsicTriangles surface = intrinsic_triangles(mesh);
    for (std::uint64_t stream = 0; stream < 20; ++stream) {
        const CounterRandom random(7, stream);
        std::vector<double> x(64);
        for (std::size_t i = 0; i < x.size(); ++i) x[i] = random.normal(i);
        const std::vector<double> Lx = apply_laplacian(surface, x);
        EXPECT_GT(std::inner_product(x.begin(), x.end(), Lx.begin(), 0.0), 0);
    }
}

// Lumped masses sum to the area; that of the icosphere tends to 4 pi.
TEST(Mass, SumsToTheArea) {
    const IntrinsicTriangles surface = intrinsic_triangles(shapes::icosphere(4));
    const double unit = surface.mean_edge_length;
    EXPECT_NEAR(total(lumped_mass(surface)) * unit * unit, 4 * std::numbers::pi, 0.02);
    const IntrinsicTriangles flat = intrinsic_triangles(shapes::grid(7, 5));
    EXPECT_NEAR(total(lumped_mass(flat)) * flat.mean_edge_length * flat.mean_edge_length, 24,
                1e-12);
}

// Delaunay: off the diagonal no entry of L is positive.
TEST(IntrinsicTriangles, HaveNoNegativeWeights) {
    long flips = 0;
    for (const TriangleMesh& mesh : obtuse_meshes()) {
        const IntrinsicTriangles surface = intrinsic_triangles(mesh);
        flips += surface.flips;
        const auto size = static_cast<std::size_t>(surface.vertex_count);
        for (std::size_t j = 0; j < size; ++j) {
            std::vector<double> unit(size, 0.0);
            unit[j] = 1;
            const std::vector<double> column = apply_laplacian(surface, unit);
            for (std::size_t i = 0; i < size; ++i) {
                EXPECT_TRUE(i == j || column[i] <= 1e-8) << "entry " << i << ", " << j;
            }
        }
    }
    EXPECT_GT(flips, 500);
}

// Flips stay within the surface: its area is that of the faces.
TEST(IntrinsicTriangles, KeepTheArea) {
    for (const TriangleMesh& mesh : obtuse_meshes()) {
        const IntrinsicTriangles surface = intrinsic_triangles(mesh);
        const double unit = surface.mean_edge_length;
        const double area = total(lumped_mass(surface)) * unit * unit;
        EXPECT_NEAR(area / surface_area(mesh), 1, 1e-11);
    }
}

// Curvature is intrinsic: the angles around each vertex sum to what they did in the mesh.
TEST(IntrinsicTriangles, KeepTheAnglesAroundEveryVertex) {
    for (const TriangleMesh& mesh : obtuse_meshes()) {
        std::vector<double> truth(mesh.vertices.size(), 0.0);
        for (const Face& face : mesh.faces) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto at = [&](std::size_t corner) {
                    return static_cast<std::size_t>(face[corner % 3]);
                };
                truth[at(k)] += angle_at(mesh.vertices[at(k)], mesh.vertices[at(k + 1)],
                                         mesh.vertices[at(k + 2)]);
            }
        }
        const std::vector<double> sums = angle_sums(intrinsic_triangles(mesh));
        for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_NEAR(sums[i], truth[i], 1e-9);
    }
}

TEST(IntrinsicTriangles, LeaveASoundMeshAsItIs) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const IntrinsicTriangles surface = intrinsic_triangles(mesh);
    EXPECT_EQ(surface.added_length, 0);
    EXPECT_EQ(surface.flips, 0);
    EXPECT_EQ(surface.triangles.size(), mesh.faces.size());
}

// Mollification: every triangle has an area and bounded cotangents afterwards, however flat it was.
TEST(IntrinsicTriangles, OpenZeroAreaFaces) {
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, 1, 0}};
    mesh.faces = {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {0, 2, 4}, {4, 5, 5}, {2, 3, 3}};
    const IntrinsicTriangles surface = intrinsic_triangles(mesh);
    EXPECT_EQ(surface.triangles.size(), 4u);
    EXPECT_GT(surface.added_length, 0);
    EXPECT_LE(surface.added_length, 1.1e-5);
    for (const FlatTriangle& triangle : surface.triangles) {
        EXPECT_GT(triangle.area(), 0);
        for (const double cotangent : triangle.cotangents()) {
            EXPECT_TRUE(std::abs(cotangent) <= 1e6) << cotangent;
        }
    }
}

TEST(IntrinsicTriangles, RefuseWhatIsNoMesh) {
    TriangleMesh mesh = shapes::grid(2, 2);
    mesh.vertices[3][1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(intrinsic_triangles(mesh), MeshError);
    mesh = shapes::grid(2, 2);
    mesh.faces[1][2] = 4;
    EXPECT_THROW(intrinsic_triangles(mesh), MeshError);
}

}  // namespace
}  // namespace mscomp
