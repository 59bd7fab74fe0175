// SPDX-License-Identifier: MIT
#include "mscomp/acap/mesh/surface_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "base/thrown_message.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using Edges = std::vector<std::array<int, 2>>;

bool is_degenerate(const Face& f) { return f[0] == f[1] || f[1] == f[2] || f[2] == f[0]; }

/// Edges of exactly one face, counted in the plainest way.
Edges counted_boundary(const std::vector<Face>& faces) {
    std::map<std::array<int, 2>, int> counts;
    for (const Face& f : faces) {
        if (is_degenerate(f)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = f[k], b = f[(k + 1) % 3];
            ++counts[{std::min(a, b), std::max(a, b)}];
        }
    }
    Edges result;
    for (const auto& [edge, count] : counts) {
        if (count == 1) result.push_back(edge);
    }
    return result;
}

/// Rings, faces around, boundaries and components are those of the faces. Returns the mesh.
SurfaceMesh expect_holds(int vertex_count, const std::vector<Face>& faces) {
    SurfaceMesh mesh(vertex_count, faces);
    const OneRings expected = one_rings_of_faces(vertex_count, faces);
    EXPECT_EQ(mesh.rings().offsets, expected.offsets);
    EXPECT_EQ(mesh.rings().neighbors, expected.neighbors);
    std::vector<std::vector<int>> around(static_cast<std::size_t>(vertex_count));
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (const int corner : faces[f]) {
            std::vector<int>& row = around[static_cast<std::size_t>(corner)];
            if (row.empty() || row.back() != static_cast<int>(f)) {
                row.push_back(static_cast<int>(f));
            }
        }
    }
    for (std::size_t i = 0; i < around.size(); ++i) {
        const VertexFaces& found = mesh.faces_around();
        const auto begin = found.faces.begin();
        EXPECT_EQ(std::vector<int>(begin + found.offsets[i], begin + found.offsets[i + 1]),
                  around[i])
            << "vertex " << i;
    }
    EXPECT_EQ(mesh.boundary_edges(), counted_boundary(faces));
    EXPECT_EQ(mesh.components(), connected_components(expected));
    return mesh;
}

TEST(SurfaceMesh, HoldsManifoldsWhole) {
    for (const TriangleMesh& mesh :
         {shapes::icosphere(2), shapes::grid(5, 4), shapes::cylinder(12, 4, 1, 2, false),
          shapes::cylinder(12, 4, 1, 2, true)}) {
        EXPECT_THAT(expect_holds(mesh.vertex_count(), mesh.faces).faces_beside(), IsEmpty());
    }
    EXPECT_EQ(SurfaceMesh(shapes::icosphere(1)).rings().neighbors.size(), 240U);
}

// Two fans that touch at a vertex: going around it passes from one to the other.
TEST(SurfaceMesh, HoldsFansThatTouchAtAVertex) {
    const SurfaceMesh bowtie = expect_holds(5, {{0, 1, 2}, {0, 3, 4}});
    EXPECT_THAT(bowtie.faces_beside(), IsEmpty());
    EXPECT_EQ(bowtie.rings().degree(0), 4);
    expect_holds(7, {{0, 1, 2}, {0, 3, 4}, {0, 5, 6}});
    // A closed fan and one more face at its middle: that does not fit, and is kept beside.
    const SurfaceMesh closed = expect_holds(6, {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {0, 4, 5}});
    EXPECT_THAT(closed.faces_beside(), ElementsAre(3));
}

TEST(SurfaceMesh, KeepsWhatIsNotManifoldBeside) {
    // A third face at an edge, a repeated one, one turned over, a vertex twice.
    EXPECT_THAT(expect_holds(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}).faces_beside(), ElementsAre(2));
    EXPECT_THAT(expect_holds(3, {{0, 1, 2}, {1, 2, 0}}).faces_beside(), ElementsAre(1));
    EXPECT_THAT(expect_holds(4, {{0, 1, 2}, {0, 1, 3}}).faces_beside(), ElementsAre(1));
    EXPECT_THAT(expect_holds(4, {{0, 0, 2}, {1, 2, 3}}).faces_beside(), ElementsAre(0));
    expect_holds(9, {{3, 4, 5}});  // and vertices without a face
    expect_holds(0, {});
}

// Whatever the heap of faces.
TEST(SurfaceMesh, HoldsAnyHeapOfFaces) {
    for (std::uint64_t trial = 0; trial < 300; ++trial) {
        const CounterRandom random(17, trial);
        const int vertex_count = 3 + static_cast<int>(random.bits(0) % 12);
        const std::uint64_t face_count = 1 + random.bits(1) % 40;
        std::vector<Face> faces;
        for (std::uint64_t i = 0; i < face_count; ++i) {
            Face face;
            for (std::uint64_t k = 0; k < 3; ++k) {
                face[k] = static_cast<int>(random.bits(2 + 3 * i + k) %
                                           static_cast<std::uint64_t>(vertex_count));
            }
            faces.push_back(face);
        }
        expect_holds(vertex_count, faces);
    }
}

// OpenMesh reports on one stream for the whole process.
TEST(SurfaceMesh, IsMadeQuietlyBySeveralThreads) {
    testing::internal::CaptureStderr();
    std::vector<std::size_t> beside(16);
    parallel_for(16, [&](std::int64_t i) {
        beside[static_cast<std::size_t>(i)] =
            SurfaceMesh(5, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}).faces_beside().size();
    });
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    for (const std::size_t count : beside) EXPECT_EQ(count, 1U);
}

TEST(SurfaceMesh, RefusesFacesOutsideTheMesh) {
    EXPECT_EQ(thrown_message<MeshError>([] {
                  SurfaceMesh(3, {{0, 1, 2}, {0, 1, 3}});
              }),
              "face 1 refers to vertex 3, the mesh has 0 to 2");
    EXPECT_THROW(SurfaceMesh(3, {{0, -1, 2}}), MeshError);
}

}  // namespace
}  // namespace mscomp
