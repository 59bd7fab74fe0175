// SPDX-License-Identifier: MIT
// check: what it says of the surface that the files make together, seams joined, and of a reference
// that is pinched.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "check_cases.h"
#include "seamed_meshes.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::HasSubstr;

TriangleMesh bulged(const TriangleMesh& mesh) {
    return mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return {p.x() + 0.1 * p.z() * p.z(), p.y(), 1.1 * p.z()};
    });
}

TEST(CheckSurface, OfASoupIsOneClosedPiece) {
    const TriangleMesh soup = shapes::soup(bumpy_sphere(1));
    const CheckReport report = check_pair(soup, bulged(soup));
    EXPECT_EQ(kinds_of(report), "coincident_vertices ");
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_loops, 0);
}

TEST(CheckSurface, OfASeamedTubeIsOpenAtItsEndsOnly) {
    const TriangleMesh tube = shapes::seamed_tube(12, 20, 1, 8);
    const CheckReport report = check_pair(tube, bulged(tube));
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_loops, 2);
    EXPECT_EQ(count_of(report, "boundary"), 2);
}

/// Two grids, one beside the other.
TriangleMesh two_grids(double gap) {
    TriangleMesh mesh = shapes::grid(4, 4);
    const int count = mesh.vertex_count();
    for (const Point& p : shapes::grid(4, 4).vertices) {
        mesh.vertices.push_back({p[0] + 3 + gap, p[1], p[2]});
    }
    for (const Face& f : shapes::grid(4, 4).faces) {
        mesh.faces.push_back({f[0] + count, f[1] + count, f[2] + count});
    }
    return mesh;
}

TEST(CheckSurface, OfPiecesThatTouchInTheReferenceOnlyIsInPieces) {
    EXPECT_EQ(check_pair(two_grids(0), two_grids(0)).components, 1);
    const CheckReport apart = check_pair(two_grids(0), two_grids(1));
    EXPECT_EQ(apart.components, 2);
    const Finding pieces = finding(apart, "several_components");
    ASSERT_EQ(pieces.places.size(), 2u);
    EXPECT_EQ(pieces.places[1].vertex, 17);
}

// Sizes are those of the file, where a place may have several vertices.
TEST(CheckSurface, CountsTheVerticesOfTheFileInAPiece) {
    TriangleMesh mesh = shapes::seamed_tube(12, 20, 1, 8);
    const TriangleMesh tube = mesh;
    for (const Point& p : tube.vertices) mesh.vertices.push_back({p[0] + 5, p[1], p[2]});
    for (const Face& f : tube.faces) {
        const int count = tube.vertex_count();
        mesh.faces.push_back({f[0] + count, f[1] + count, f[2] + count});
    }
    const Finding pieces = finding(check_pair(mesh, bulged(mesh)), "several_components");
    ASSERT_EQ(pieces.places.size(), 2u);
    for (const CheckPlace& piece : pieces.places) EXPECT_EQ(piece.count, tube.vertex_count());
}

constexpr int kPinchedVertex = 1000;

/// The ring of a vertex so many times as wide: drawn together, as lips that are shut, or torn open.
TriangleMesh with_ring(const TriangleMesh& mesh, double width) {
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    TriangleMesh result = mesh;
    const Vector3d center = vec(mesh.vertices[kPinchedVertex]);
    for (int k = rings.offsets[kPinchedVertex]; k < rings.offsets[kPinchedVertex + 1]; ++k) {
        Point& p = result.vertices[at(rings.neighbors[at(k)])];
        p = point(center + width * (vec(p) - center));
    }
    return result;
}

class CheckPinch : public testing::Test {
  protected:
    CheckPinch() {
        shapes_.add(with_ring(open_, 0.03));
        for (int k = 1; k < 4; ++k) {
            shapes_.add(mapped(open_, [=](const Vector3d& p) -> Vector3d {
                return {(1 + 0.02 * k) * p.x(), p.y(), p.z()};
            }));
        }
    }

    TriangleMesh open_ = bumpy_sphere(5);
    CheckedShapes shapes_;
};

TEST_F(CheckPinch, IsAFaultOfTheReferenceAndNotOfTheShapes) {
    const CheckReport report = shapes_.check();
    const Finding found = finding(report, "reference_pinched");
    EXPECT_EQ(found.count, 3);
    EXPECT_EQ(found.severity, Severity::warning);
    ASSERT_FALSE(found.places.empty());
    EXPECT_EQ(found.places[0].file, shapes_.paths().at(1));
    EXPECT_THAT(found.advice, HasSubstr("Nothing is wrong with the shapes"));
    EXPECT_EQ(count_of(report, "stretch_outlier"), 0);
}

TEST_F(CheckPinch, IsMendedByAnotherReference) {
    CheckOptions options;
    options.reference_index = 1;
    EXPECT_EQ(count_of(shapes_.check(options), "reference_pinched"), 0);
}

// Far wider than usual, whether the reference is pinched there or not.
TEST_F(CheckPinch, IsNoExcuseForAShapeThatIsTornThere) {
    const TriangleMesh torn = with_ring(open_, 6);
    CheckedShapes of_open;
    for (int k = 0; k < 4; ++k) of_open.add(open_);
    of_open.add(torn);
    EXPECT_EQ(count_of(of_open.check(), "reference_pinched"), 0);
    EXPECT_EQ(count_of(of_open.check(), "stretch_outlier"), 1);

    shapes_.add(torn);
    EXPECT_EQ(count_of(shapes_.check(), "reference_pinched"), 3);
    EXPECT_EQ(count_of(shapes_.check(), "stretch_outlier"), 1);
}

}  // namespace
}  // namespace mscomp
