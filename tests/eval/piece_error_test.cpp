// SPDX-License-Identifier: MIT
#include "mscomp/eval/piece_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mscomp/base/error.h"
#include "shapes.h"

namespace mscomp {
namespace {

/// A ball, and one a tenth as large beside it.
TriangleMesh two_balls() {
    TriangleMesh mesh = shapes::icosphere(2);
    const int first = mesh.vertex_count();
    const TriangleMesh second = shapes::icosphere(1);
    for (const Point& p : second.vertices) {
        mesh.vertices.push_back({2 + 0.1 * p[0], 0.1 * p[1], 0.1 * p[2]});
    }
    for (const Face& f : second.faces) {
        mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    return mesh;
}

TEST(PieceRmsError, IsThatOfTheWholeWhereThereIsOnePiece) {
    const TriangleMesh mesh = shapes::icosphere(2);
    std::vector<Point> result = mesh.vertices;
    for (Point& p : result) p[0] *= 1.1;
    PieceRmsError pieces(mesh);
    RmsError whole(mesh.vertices);
    pieces.add(mesh.vertices, result);
    whole.add(mesh.vertices, result);
    EXPECT_EQ(pieces.piece_count(), 1);
    EXPECT_NEAR(pieces.value(), whole.value(), 1e-9);
}

TEST(PieceRmsError, DoesNotSeeAPieceThatMovesAndTheWholeDoes) {
    const TriangleMesh mesh = two_balls();
    std::vector<Point> result = mesh.vertices;
    for (std::size_t v = 162; v < result.size(); ++v) result[v][1] += 0.3;
    PieceRmsError pieces(mesh);
    RmsError whole(mesh.vertices);
    EXPECT_TRUE(std::isnan(pieces.value()));
    pieces.add(mesh.vertices, result);
    whole.add(mesh.vertices, result);
    EXPECT_EQ(pieces.piece_count(), 2);
    EXPECT_LT(pieces.value(), 1e-9);
    EXPECT_GT(whole.value(), 10);
}

TEST(PieceRmsError, WantsTheVerticesOfTheReference) {
    PieceRmsError pieces(two_balls());
    EXPECT_THROW(pieces.add(two_balls().vertices, shapes::icosphere(2).vertices), MeshError);
}

}  // namespace
}  // namespace mscomp
