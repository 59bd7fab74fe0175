// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/error.h"
#include "mscomp/base/random.h"
#include "seamed_meshes.h"
#include "shapes.h"

namespace mscomp {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ConnectivityReport report_of(int vertex_count, const std::vector<Face>& faces) {
    const SurfaceConnectivity surface = analyze_connectivity(vertex_count, faces);
    const OneRings expected = one_rings_of_faces(vertex_count, faces);
    EXPECT_EQ(surface.rings.offsets, expected.offsets);
    EXPECT_EQ(surface.rings.neighbors, expected.neighbors);
    EXPECT_EQ(surface.report.vertex_count, vertex_count);
    EXPECT_EQ(surface.report.face_count, static_cast<int>(faces.size()));
    return surface.report;
}

ConnectivityReport report_of(const TriangleMesh& mesh) {
    return report_of(mesh.vertex_count(), mesh.faces);
}

TEST(Connectivity, OfAClosedSurfaceHasNothingToReport) {
    const ConnectivityReport report = report_of(shapes::icosphere(2));
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_edges, 0);
    EXPECT_EQ(report.boundary_loops, 0);
    EXPECT_EQ(report.non_manifold_edges, 0);
    EXPECT_EQ(report.non_manifold_vertices, 0);
    EXPECT_EQ(report.faces_beside, 0);
    EXPECT_THAT(report.warnings, IsEmpty());
}

// An open cylinder has two boundaries of as many edges as there are vertices around it.
TEST(Connectivity, CountsBoundaries) {
    const ConnectivityReport open = report_of(shapes::cylinder(12, 4, 1, 2, false));
    EXPECT_EQ(open.boundary_edges, 24);
    EXPECT_EQ(open.boundary_loops, 2);
    EXPECT_THAT(open.warnings, ElementsAre(HasSubstr("2 boundaries of together 24 edges")));
    const ConnectivityReport flat = report_of(shapes::grid(4, 3));
    EXPECT_EQ(flat.boundary_edges, 10);
    EXPECT_EQ(flat.boundary_loops, 1);
    EXPECT_EQ(report_of(shapes::cylinder(12, 4, 1, 2, true)).boundary_edges, 0);
}

TEST(Connectivity, CountsComponentsAndIsolatedVertices) {
    TriangleMesh mesh = shapes::icosphere(0);
    const int first = mesh.vertex_count();
    for (const Face& face : shapes::icosphere(0).faces) {
        mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
    }
    const ConnectivityReport report = report_of(2 * first + 3, mesh.faces);
    EXPECT_EQ(report.components, 2);
    EXPECT_EQ(report.isolated_vertices, 3);
    EXPECT_THAT(report.warnings, ElementsAre("2 connected components",
                                             "3 vertices are in no face, the first is vertex 25"));
}

// Three faces at one edge, as the pages of a book.
TEST(Connectivity, CountsEdgesWithMoreThanTwoFaces) {
    const ConnectivityReport report = report_of(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    EXPECT_EQ(report.non_manifold_edges, 1);
    EXPECT_EQ(report.non_manifold_vertices, 0);
    EXPECT_EQ(report.faces_beside, 1);
    EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("between the vertices 1 and 2")));
}

TEST(Connectivity, CountsNeighborsOfOppositeOrientation) {
    const ConnectivityReport report = report_of(4, {{0, 1, 2}, {0, 1, 3}});
    EXPECT_EQ(report.non_manifold_edges, 1);
    EXPECT_EQ(report.boundary_edges, 4);
    EXPECT_EQ(report.faces_beside, 1);
}

// Two triangles that touch in a vertex: two fans there.
TEST(Connectivity, CountsVerticesWhereSurfacesTouch) {
    const ConnectivityReport report = report_of(5, {{0, 1, 2}, {0, 3, 4}});
    EXPECT_EQ(report.non_manifold_vertices, 1);
    EXPECT_EQ(report.non_manifold_edges, 0);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_loops, 1);
    EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("the first is vertex 1")));
}

TEST(Connectivity, SeesAClosedFanTouchedByAnother) {
    TriangleMesh mesh = shapes::icosphere(0);
    mesh.faces.push_back({0, 12, 13});
    const ConnectivityReport report = report_of(14, mesh.faces);
    EXPECT_EQ(report.non_manifold_vertices, 1);
    EXPECT_EQ(report.faces_beside, 1);
}

TEST(Connectivity, CountsFacesThatRepeatAnotherInAnyOrientation) {
    const ConnectivityReport report =
        report_of(4, {{0, 1, 2}, {2, 1, 3}, {1, 2, 0}, {0, 2, 1}, {3, 2, 1}});
    EXPECT_EQ(report.duplicate_faces, 3);
    EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("the first is face 3, as face 1")));
}

TEST(Connectivity, CountsFacesWithAVertexTwice) {
    const ConnectivityReport report = report_of(4, {{0, 1, 2}, {1, 1, 3}, {2, 2, 2}});
    EXPECT_EQ(report.degenerate_faces, 2);
    EXPECT_EQ(report.faces_beside, 2);
    EXPECT_EQ(report.non_manifold_vertices, 0);
    EXPECT_EQ(report.boundary_edges, 3);
    EXPECT_EQ(report.isolated_vertices, 0);
    EXPECT_THAT(report.warnings, testing::Contains(HasSubstr("the first is face 2")));
}

// OpenMesh may refuse whatever it likes: the rings hold every edge all the same.
TEST(Connectivity, RingsHoldEveryEdgeOfAnyHeapOfFaces) {
    for (std::uint64_t trial = 0; trial < 300; ++trial) {
        const CounterRandom random(5, trial);
        const int vertex_count = 3 + static_cast<int>(random.bits(0) % 12);
        const int face_count = 1 + static_cast<int>(random.bits(1) % 40);
        std::vector<Face> faces;
        for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(face_count); ++i) {
            Face face;
            for (std::uint64_t k = 0; k < 3; ++k) {
                face[k] = static_cast<int>(random.bits(2 + 3 * i + k) %
                                           static_cast<std::uint64_t>(vertex_count));
            }
            faces.push_back(face);
        }
        report_of(vertex_count, faces);
    }
}

// A surface whose faces come in a random order and of which some are missing.
TEST(Connectivity, RingsHoldEveryEdgeOfASurfaceInPieces) {
    const TriangleMesh sphere = shapes::icosphere(1);
    for (std::uint64_t trial = 0; trial < 300; ++trial) {
        const CounterRandom random(6, trial);
        std::vector<Face> faces;
        for (const int i : random.permutation(sphere.face_count())) {
            if (random.uniform(1000 + static_cast<std::uint64_t>(i)) < 0.7) {
                faces.push_back(sphere.faces[static_cast<std::size_t>(i)]);
            }
        }
        EXPECT_EQ(report_of(sphere.vertex_count(), faces).non_manifold_edges, 0);
    }
}

TEST(Connectivity, RefusesFacesOutsideTheMesh) {
    EXPECT_THAT(thrown_message<MeshError>([] {
                    analyze_connectivity(3, {{0, 1, 2}, {0, 1, 3}});
                }),
                HasSubstr("vertex 3"));
    EXPECT_THROW(analyze_connectivity(3, {{0, -1, 2}}), MeshError);
}

/// Places of vertices that lie exactly on each other.
VertexPlaces places_of(const TriangleMesh& mesh) {
    std::map<Point, int> first;
    std::vector<int> lowest;
    for (const Point& p : mesh.vertices) {
        lowest.push_back(first.try_emplace(p, static_cast<int>(lowest.size())).first->second);
    }
    return {lowest, mesh.faces};
}

// Each triangle of a soup is a piece with a boundary of its own only as long as nobody joins them.
TEST(Connectivity, OfPlacesIsThatOfTheClosedSurface) {
    const TriangleMesh soup = shapes::soup(shapes::icosphere(1));
    EXPECT_EQ(report_of(soup).components, soup.face_count());
    EXPECT_EQ(report_of(soup).boundary_loops, soup.face_count());
    const ConnectivityReport joined =
        analyze_connectivity(soup.vertex_count(), soup.faces, {}, places_of(soup)).report;
    EXPECT_EQ(joined.components, 1);
    EXPECT_THAT(joined.warnings, IsEmpty());
}

// Vertices are named as in the file, and what no face of the file uses is told from what is joined.
TEST(Connectivity, OfPlacesKeepsTheNumbersOfTheFile) {
    TriangleMesh mesh = shapes::soup(shapes::grid(2, 2));
    mesh.vertices.push_back({9, 9, 9});
    const ConnectivityReport joined =
        analyze_connectivity(mesh.vertex_count(), mesh.faces, {}, places_of(mesh)).report;
    EXPECT_EQ(joined.boundary_loops, 1);
    EXPECT_EQ(joined.boundary_edges, 4);
    EXPECT_EQ(joined.isolated_vertices, 1);
    EXPECT_THAT(joined.warnings, Contains(HasSubstr("in no face, the first is vertex 7")));
}

}  // namespace
}  // namespace mscomp
