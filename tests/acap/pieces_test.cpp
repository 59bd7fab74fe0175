// SPDX-License-Identifier: MIT
// Where the pieces of a mesh lie to each other when features are all there is.
#include <gtest/gtest.h>

#include <algorithm>

#include "acap/reconstruct/piece_links.h"
#include "acap_cases.h"
#include "mscomp/acap/reconstruct.h"

namespace mscomp {
namespace {

using namespace cases;

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
    TriangleMesh both = a;
    both.vertices.insert(both.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const Face& f : b.faces) {
        const int n = a.vertex_count();
        both.faces.push_back({f[0] + n, f[1] + n, f[2] + n});
    }
    return both;
}

TriangleMesh scaled(const TriangleMesh& mesh, double factor, const Vector3d& move) {
    return mapped(mesh, [=](const Vector3d& p) -> Vector3d { return factor * p + move; });
}

/// A head with an eye before it.
TriangleMesh head_with_eye() {
    return joined(bumpy_sphere(2), scaled(shapes::icosphere(1), 0.2, {1.5, 0.2, 0.1}));
}

double largest_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, (vec(a[i]) - vec(b[i])).norm());
    }
    return largest;
}

TEST(PieceJoints, EveryVertexOfTheSmallerIsLinkedToTheNearest) {
    const TriangleMesh mesh =
        joined(joined(head_with_eye(), scaled(shapes::icosphere(0), 0.1, {1.8, 0.2, 0.1})),
               scaled(shapes::icosphere(0), 0.1, {-2, 0, 0}));
    const std::vector<int> piece =
        connected_components(one_rings_of_faces(mesh.vertex_count(), mesh.faces));
    const std::vector<PieceJoint> joints = piece_joints(mesh.vertices, piece);
    ASSERT_EQ(joints.size(), 3u);
    std::vector<char> held(4, 0);
    held[0] = 1;
    for (const PieceJoint& joint : joints) {
        EXPECT_TRUE(held[at(joint.from)] != 0 && held[at(joint.to)] == 0);
        held[at(joint.to)] = 1;
        EXPECT_EQ(joint.from, joint.to == 2 ? 1 : 0);  // the third hangs on the eye
        EXPECT_EQ(static_cast<int>(joint.links.size()), std::ranges::count(piece, joint.to));
        for (const PieceLink& link : joint.links) {
            double nearest = 1e9;
            for (int v = 0; v < mesh.vertex_count(); ++v) {
                if (piece[at(v)] != joint.from) continue;
                nearest = std::min(
                    nearest, (vec(mesh.vertices[at(v)]) - vec(mesh.vertices[at(link.to)])).norm());
            }
            EXPECT_DOUBLE_EQ(
                (vec(mesh.vertices[at(link.from)]) - vec(mesh.vertices[at(link.to)])).norm(),
                nearest);
        }
    }
}

// The eye turns with the head: nobody has to say where it lies.
TEST(Pieces, WhatMovesAsOneStaysTogether) {
    const TriangleMesh mesh = head_with_eye();
    const TriangleMesh turned = mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return rotation_about({0.3, 1, 0.2}, 1.1) * p * 1.2;
    });
    const FeatureSet set = extract_one(mesh, turned);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
    const auto like = std::span<const Point>(turned.vertices);
    EXPECT_LT(largest_distance(lossless.solve(set.shape(0), like, Pieces::joined).vertices,
                               turned.vertices),
              1e-5);
    EXPECT_LT(largest_distance(poisson.solve(set.shape(0), like, Pieces::joined), turned.vertices),
              1e-5);
    const std::vector<Point> free = lossless.solve(set.shape(0)).vertices;
    EXPECT_NEAR((vec(free.front()) - vec(free.back())).norm(),
                (vec(turned.vertices.front()) - vec(turned.vertices.back())).norm(), 1e-5);
}

// A piece that moves by itself leaves no trace in the features, and no other shape may tell.
TEST(Pieces, AMoveThatFeaturesDoNotShowIsNotTakenFromTheOtherShape) {
    const TriangleMesh mesh = head_with_eye();
    TriangleMesh moved = mesh;
    const auto first = bumpy_sphere(2).vertices.size();
    for (std::size_t v = first; v < moved.vertices.size(); ++v) moved.vertices[v][1] += 0.3;
    const FeatureSet set = extract_one(mesh, moved);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const auto like = std::span<const Point>(moved.vertices);
    EXPECT_LT(largest_distance(lossless.solve(set.shape(0), like).vertices, moved.vertices), 1e-5);
    const std::vector<Point> own = lossless.solve(set.shape(0), like, Pieces::joined).vertices;
    EXPECT_NEAR(largest_distance(own, moved.vertices), 0.3, 0.1);
}

}  // namespace
}  // namespace mscomp
