// SPDX-License-Identifier: MIT
#include "mscomp/base/mesh_data.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "shapes.h"

namespace mscomp {
namespace {

std::vector<int> ring_of(const OneRings& rings, int vertex) {
    const auto at = static_cast<std::size_t>(vertex);
    return {rings.neighbors.begin() + rings.offsets[at],
            rings.neighbors.begin() + rings.offsets[at + 1]};
}

// Euler: a closed surface of genus 0 has E = V + F - 2 edges, each in two rings.
TEST(OneRings, OfASphereHoldEveryEdgeTwice) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    const int edges = mesh.vertex_count() + mesh.face_count() - 2;
    EXPECT_EQ(rings.neighbors.size(), static_cast<std::size_t>(2 * edges));
    EXPECT_EQ(rings.degree(0), 5);
}

TEST(OneRings, AreAscendingSymmetricAndWithoutTheVertexItself) {
    for (const TriangleMesh& mesh : {shapes::cylinder(9, 5, 1, 3, true), shapes::grid(4, 3)}) {
        const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
        for (int i = 0; i < mesh.vertex_count(); ++i) {
            const std::vector<int> ring = ring_of(rings, i);
            EXPECT_EQ(std::adjacent_find(ring.begin(), ring.end(), std::greater_equal<>()),
                      ring.end());
            for (const int j : ring) {
                EXPECT_NE(j, i);
                const std::vector<int> back = ring_of(rings, j);
                EXPECT_TRUE(std::binary_search(back.begin(), back.end(), i));
            }
        }
    }
}

TEST(OneRings, OfAFaceWithAVertexTwiceHoldItsOneEdge) {
    const OneRings rings = one_rings_of_faces(3, {{0, 0, 2}});
    EXPECT_EQ(ring_of(rings, 0), std::vector<int>{2});
    EXPECT_EQ(ring_of(rings, 1), std::vector<int>{});
    EXPECT_EQ(ring_of(rings, 2), std::vector<int>{0});
}

TEST(ConnectedComponents, AreNumberedByTheirLowestVertex) {
    const OneRings rings = one_rings_of_faces(8, {{1, 4, 6}, {0, 2, 3}, {3, 7, 2}});
    EXPECT_EQ(connected_components(rings), (std::vector<int>{0, 1, 0, 0, 1, 2, 1, 0}));
}

}  // namespace
}  // namespace mscomp
