// SPDX-License-Identifier: MIT
#include "mscomp/geodesic/heat_geodesics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "shapes.h"

namespace mscomp {
namespace {

double great_circle(const Point& p, const Point& q) {
    const double sine =
        std::hypot(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]);
    return std::atan2(sine, p[0] * q[0] + p[1] * q[1] + p[2] * q[2]);
}

double euclidean(const Point& p, const Point& q) {
    return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

/// On a cylinder of radius 1 around z.
double unrolled_cylinder(const Point& p, const Point& q) {
    const double turn = std::atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
    return std::hypot(turn, q[2] - p[2]);
}

/// Largest |computed - true| / (largest true distance) over all vertices.
template <class Metric>
double worst_error(const TriangleMesh& mesh, int source, Metric metric) {
    const std::vector<double> row = HeatGeodesics(mesh).distances(source);
    double error = 0, largest = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        const double truth =
            metric(mesh.vertices[static_cast<std::size_t>(source)], mesh.vertices[i]);
        largest = std::max(largest, truth);
        const double off = std::abs(row[i] - truth);
        if (!(off <= error)) error = off;
    }
    return error / largest;
}

double asymmetry(const HeatGeodesics& geodesics, int a, int b) {
    const double there = geodesics.distances(a)[static_cast<std::size_t>(b)];
    const double back = geodesics.distances(b)[static_cast<std::size_t>(a)];
    return std::abs(there - back) / std::max(there, back);
}

/// `first` and a copy of `second` moved far away, sharing no vertex.
TriangleMesh beside(TriangleMesh first, const TriangleMesh& second) {
    const int offset = first.vertex_count();
    for (const Point& p : second.vertices) first.vertices.push_back({p[0] + 50, p[1], p[2]});
    for (const Face& f : second.faces) {
        first.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
    }
    return first;
}

/// A flat grid sheared by `shear` against its diagonals.
TriangleMesh grid_with_long_diagonals(int columns, double shear) {
    TriangleMesh mesh = shapes::grid(columns, columns);
    for (Face& f : mesh.faces) {
        const int a = *std::min_element(f.begin(), f.end());
        f = f[1] == a + 1 ? Face{a, a + 1, a + columns} : Face{a + 1, a + columns + 1, a + columns};
    }
    for (Point& p : mesh.vertices) p[0] -= shear * p[1];
    return mesh;
}

void expect_sound(const std::vector<double>& row, int source) {
    for (const double distance : row) EXPECT_TRUE(distance >= 0 && std::isfinite(distance));
    EXPECT_EQ(row[static_cast<std::size_t>(source)], 0);
}

// On the unit sphere distances are arc lengths: within 2.5 % of the diameter on 2,562 vertices.
TEST(HeatGeodesics, FollowGreatCircles) {
    const TriangleMesh mesh = shapes::icosphere(4);
    for (const int source : {0, 100, 1500}) {
        EXPECT_TRUE(worst_error(mesh, source, great_circle) <= 0.025) << "source " << source;
    }
}

// The error falls with the edge length.
TEST(HeatGeodesics, GetBetterWithRefinement) {
    double coarser = worst_error(shapes::icosphere(2), 0, great_circle);
    for (const int level : {3, 4, 5}) {
        const double finer = worst_error(shapes::icosphere(level), 0, great_circle);
        EXPECT_TRUE(finer <= 0.65 * coarser) << "level " << level << ": " << finer;
        coarser = finer;
    }
}

// In the plane distances are Euclidean.
TEST(HeatGeodesics, AreEuclideanOnAFlatGrid) {
    const int columns = 61;
    const TriangleMesh mesh = shapes::grid(columns, columns);
    EXPECT_TRUE(worst_error(mesh, 30 * columns + 30, euclidean) <= 0.03);
}

// Needles stay Euclidean: with the longer diagonal in every square, most triangles are obtuse.
TEST(HeatGeodesics, StayEuclideanOnObtuseTriangles) {
    const TriangleMesh mesh = grid_with_long_diagonals(41, 2.0);
    EXPECT_TRUE(worst_error(mesh, 20 * 41 + 20, euclidean) <= 0.05);
}

// Where every edge has four triangles none can be flipped: heat stays positive all the same, so
// that distances are off by a part of their size and not altogether wrong.
TEST(HeatGeodesics, StayUsableWhereObtuseTrianglesAreNotManifold) {
    TriangleMesh mesh = grid_with_long_diagonals(41, 1.0);
    const std::vector<Face> once = mesh.faces;
    mesh.faces.insert(mesh.faces.end(), once.begin(), once.end());
    EXPECT_TRUE(worst_error(mesh, 20 * 41 + 20, euclidean) <= 0.35);
}

// On a cylinder unrolled: hypot(arc, height).
TEST(HeatGeodesics, UnrollACylinder) {
    const TriangleMesh mesh = shapes::cylinder(60, 61, 1, 6, false);
    EXPECT_TRUE(worst_error(mesh, 30 * 60, unrolled_cylinder) <= 0.05);
}

// d(a, b) = d(b, a), up to the error of the method.
TEST(HeatGeodesics, AreNearlySymmetric) {
    const HeatGeodesics geodesics(shapes::icosphere(4));
    EXPECT_TRUE(asymmetry(geodesics, 0, 3) <= 0.01);
    EXPECT_TRUE(asymmetry(geodesics, 17, 2000) <= 0.01);
    EXPECT_TRUE(asymmetry(geodesics, 5, 900) <= 0.02);
}

// d(a, c) <= d(a, b) + d(b, c), up to the error of the method.
TEST(HeatGeodesics, NearlyKeepTheTriangleInequality) {
    const TriangleMesh mesh = shapes::icosphere(3);
    const HeatGeodesics geodesics(mesh);
    const std::vector<double> from_a = geodesics.distances(0);
    const std::vector<double> from_b = geodesics.distances(300);
    for (std::size_t c = 0; c < from_a.size(); ++c) {
        EXPECT_TRUE(from_a[c] <= (from_a[300] + from_b[c]) * 1.02 + 0.05) << "vertex " << c;
    }
}

// Scaling the mesh scales the distances, whatever the unit.
TEST(HeatGeodesics, DoNotDependOnTheUnit) {
    const TriangleMesh mesh = shapes::cylinder(20, 15, 1, 3, true);
    const std::vector<double> truth = HeatGeodesics(mesh).distances(3);
    for (const double scale : {1e-8, 1e-3, 1e3, 1e8}) {
        TriangleMesh scaled = mesh;
        for (Point& p : scaled.vertices) p = {p[0] * scale, p[1] * scale, p[2] * scale};
        const std::vector<double> row = HeatGeodesics(scaled).distances(3);
        for (std::size_t i = 0; i < row.size(); ++i) {
            EXPECT_NEAR(row[i] / scale, truth[i], 1e-11) << "scale " << scale;
        }
    }
}

TEST(HeatGeodesics, ReachOnlyTheComponentOfTheSource) {
    const TriangleMesh sphere = shapes::icosphere(2);
    TriangleMesh mesh = beside(sphere, shapes::grid(5, 5));
    mesh.vertices.push_back({9, 9, 9});
    const std::vector<double> alone = HeatGeodesics(sphere).distances(7);
    const std::vector<double> row = HeatGeodesics(mesh).distances(7);
    for (std::size_t i = 0; i < row.size(); ++i) {
        // The time step follows the mean edge length of all components, hence the tolerance.
        if (i < alone.size()) {
            EXPECT_NEAR(row[i], alone[i], 0.2);
        } else {
            EXPECT_TRUE(std::isinf(row[i]) && row[i] > 0) << "vertex " << i;
        }
    }
}

TEST(HeatGeodesics, GiveALonelyVertexOnlyItself) {
    TriangleMesh mesh = shapes::grid(4, 4);
    mesh.vertices.push_back({1, 1, 1});
    const std::vector<double> row = HeatGeodesics(mesh).distances(16);
    EXPECT_EQ(row[16], 0);
    for (std::size_t i = 0; i < 16; ++i) EXPECT_TRUE(std::isinf(row[i]));
}

// One solve serves one source per component.
TEST(HeatGeodesics, SolveAllComponentsAtOnce) {
    const TriangleMesh mesh = beside(shapes::icosphere(2), shapes::grid(5, 5));
    const HeatGeodesics geodesics(mesh);
    const std::vector<double> first = geodesics.distances(7), second = geodesics.distances(170);
    const std::vector<std::vector<int>> sets{{7, 170}};
    const std::vector<double> both = geodesics.distance_rows(sets).front();
    for (std::size_t i = 0; i < both.size(); ++i) {
        EXPECT_EQ(both[i], std::min(first[i], second[i]));
    }
}

// Faces without area, doubled faces, three faces at an edge, two fans at a vertex: all finite, and
// the distances in the healthy part stay close to Euclid.
TEST(HeatGeodesics, SurviveBadMeshes) {
    const int columns = 21;
    TriangleMesh mesh = shapes::grid(columns, columns);
    mesh.faces.push_back({0, 1, 2});       // zero area: on a line
    mesh.faces.push_back({5, 5, 6});       // a vertex twice
    mesh.faces.push_back(mesh.faces[10]);  // twice the same
    mesh.vertices.push_back({10, 10, 3});  // 441: third face at an edge
    mesh.faces.push_back({10 * columns + 10, 10 * columns + 11, 441});
    mesh.vertices.push_back({-1, -1, 0});  // 442, 443: a fan at a corner
    mesh.vertices.push_back({-1, -2, 0});
    mesh.faces.push_back({0, 442, 443});
    mesh.vertices.push_back(mesh.vertices[50]);  // 444: two vertices in one place
    mesh.faces.push_back({50, 51, 444});
    const int source = 10 * columns + 10;
    const std::vector<double> row = HeatGeodesics(mesh).distances(source);
    expect_sound(row, source);
    for (int i = 0; i < columns * columns; ++i) {
        const auto at = static_cast<std::size_t>(i);
        EXPECT_NEAR(row[at], euclidean(mesh.vertices[at], mesh.vertices[220]), 1.0);
    }
}

TEST(HeatGeodesics, AreZeroWhereAllPointsCoincide) {
    TriangleMesh mesh = shapes::grid(3, 3);
    for (Point& p : mesh.vertices) p = {1, 2, 3};
    for (const double distance : HeatGeodesics(mesh).distances(4)) EXPECT_EQ(distance, 0);
}

// A strip of 900 edges: heat fades by e^-900, far below the smallest double at unit source heat.
TEST(HeatGeodesics, ReachFarAlongALongStrip) {
    const TriangleMesh mesh = shapes::grid(900, 3);
    const std::vector<double> row = HeatGeodesics(mesh).distances(900);
    EXPECT_NEAR(row[900 + 899], 899, 9);
}

// On a cylinder of 3,000 rings, far longer than heat at t = h^2 reaches: hypot(arc, height) still.
TEST(HeatGeodesics, ReachTheEndOfALongCylinder) {
    const int around = 8, rings = 3000;
    const double spacing = 2 * std::numbers::pi / around;
    const TriangleMesh mesh = shapes::cylinder(around, rings, 1, (rings - 1) * spacing, true);
    for (const int source : {0, around * rings / 2}) {
        EXPECT_TRUE(worst_error(mesh, source, unrolled_cylinder) <= 0.002) << "source " << source;
    }
}

// Only components that need it take larger steps: beside a long one, a sphere keeps its distances.
TEST(HeatGeodesics, TakeTheStepOfTheirOwnComponent) {
    const TriangleMesh sphere = shapes::icosphere(4);
    const double edge = 0.06;  // about that of the sphere
    TriangleMesh strip = shapes::grid(5000, 2);
    for (Point& p : strip.vertices) p = {p[0] * edge, p[1] * edge, p[2]};
    const TriangleMesh mesh = beside(sphere, strip);
    const std::vector<double> alone = HeatGeodesics(sphere).distances(0);
    const std::vector<double> row = HeatGeodesics(mesh).distances(0);
    double worst = 0;
    for (std::size_t i = 0; i < alone.size(); ++i) {
        worst = std::max(worst, std::abs(row[i] - alone[i]));
    }
    // What is left comes from the mean edge length, which is that of both.
    EXPECT_TRUE(worst <= 0.003) << worst;
}

TEST(HeatGeodesics, AreBitwiseEqualForAnyNumberOfThreads) {
    const HeatGeodesics geodesics(shapes::icosphere(3));
    std::vector<int> sources;
    for (int i = 0; i < 45; ++i) sources.push_back(13 * i);
    set_thread_count(1);
    const auto truth = geodesics.distance_rows(sources);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(geodesics.distance_rows(sources), truth) << threads << " threads";
    }
    set_thread_count(0);
    for (std::size_t k = 0; k < sources.size(); ++k) {
        EXPECT_EQ(geodesics.distances(sources[k]), truth[k]) << "row by itself";
    }
}

TEST(HeatGeodesics, RefuseATimeFactorThatIsNotPositive) {
    EXPECT_THROW(HeatGeodesics(shapes::grid(3, 3), 0), UsageError);
    EXPECT_THROW(HeatGeodesics(shapes::grid(3, 3), std::nan("")), UsageError);
}

TEST(HeatGeodesics, AcceptAnEmptyMesh) {
    const HeatGeodesics geodesics{TriangleMesh{}};
    EXPECT_EQ(geodesics.vertex_count(), 0);
    EXPECT_EQ(geodesic_normalizer(geodesics).largest_distance, 0);
}

}  // namespace
}  // namespace mscomp
