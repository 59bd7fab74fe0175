// SPDX-License-Identifier: MIT
#include "acap/edge_weights.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "acap_cases.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace cases;

double weight(const TriangleMesh& mesh, EdgeWeights kind, int i, int j) {
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    const EdgeWeightTable table = edge_weights(mesh, rings, kind);
    const auto begin = rings.neighbors.begin() + rings.offsets[at(i)];
    const auto end = rings.neighbors.begin() + rings.offsets[at(i) + 1];
    return table.weights[at(static_cast<int>(std::find(begin, end, j) - rings.neighbors.begin()))];
}

/// Right angle at 0, 30 degrees at 1, 60 degrees at 2; a mirrored copy below the edge 0-1.
TriangleMesh kite() {
    TriangleMesh mesh;
    const double h = 1 / std::sqrt(3.0);
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, h, 0}, {0, -h, 0}};
    mesh.faces = {{0, 1, 2}, {1, 0, 3}};
    return mesh;
}

TEST(EdgeWeights, CotangentsOfKnownAngles) {
    // Inner edge: two angles of 60 degrees; boundary edges: one of 30, and one right angle
    // (clamped).
    EXPECT_NEAR(weight(kite(), EdgeWeights::cotangent, 0, 1), 1 / std::sqrt(3.0), 1e-15);
    EXPECT_NEAR(weight(kite(), EdgeWeights::cotangent, 0, 2), std::sqrt(3.0) / 2, 1e-15);
    EXPECT_EQ(weight(kite(), EdgeWeights::cotangent, 1, 2), 1e-3);
}

TEST(EdgeWeights, AuthorsFormulaOnBothSidesOfZero) {
    EXPECT_NEAR(weight(kite(), EdgeWeights::authors, 0, 1), std::sqrt(1 + 1 / std::sqrt(3.0)),
                1e-15);
    TriangleMesh obtuse = kite();
    obtuse.vertices[2] = {0.5, 0.1, 0};  // tip with a wide angle over the edge 0-1
    obtuse.vertices[3] = {0.5, -0.1, 0};
    const double cotangent = (0.1 * 0.1 - 0.25) / (2 * 0.1 * 0.5);
    EXPECT_NEAR(weight(obtuse, EdgeWeights::authors, 0, 1), std::exp(cotangent / 2), 1e-15);
    EXPECT_EQ(weight(obtuse, EdgeWeights::cotangent, 0, 1), 1e-3);
    EXPECT_EQ(weight(obtuse, EdgeWeights::uniform, 0, 1), 1);
}

TEST(EdgeWeights, DoNotDependOnTheUnit) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    for (const EdgeWeights kind : {EdgeWeights::cotangent, EdgeWeights::authors}) {
        const auto one = edge_weights(mesh, rings, kind).weights;
        for (const double unit : {1e-8, 1e8}) {
            const TriangleMesh scaled =
                mapped(mesh, [=](const Vector3d& p) -> Vector3d { return unit * p; });
            const auto other = edge_weights(scaled, rings, kind).weights;
            for (std::size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(other[k], one[k], 1e-12);
        }
    }
}

// Σ_j c_ij (p_i - p_j) = 0 inside a flat mesh: the cotangent Laplacian is linearly precise.
TEST(EdgeWeights, CotangentLaplacianIsLinearlyPrecise) {
    const TriangleMesh mesh = mapped(shapes::grid(6, 6), [](const Vector3d& p) -> Vector3d {
        // Nearly equilateral, so that no angle is obtuse and no weight clamped.
        return Vector3d(p.x() - 0.5 * p.y() + 0.05 * std::sin(p.y()),
                        0.9 * p.y() + 0.05 * std::sin(2 * p.x()), 0);
    });
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    const auto weights = edge_weights(mesh, rings, EdgeWeights::cotangent).weights;
    ASSERT_GT(*std::min_element(weights.begin(), weights.end()), 0);
    for (const int i : {7, 8, 14, 21, 28}) {
        Vector3d sum = Vector3d::Zero();
        for (int k = rings.offsets[at(i)]; k < rings.offsets[at(i) + 1]; ++k) {
            ASSERT_GT(weights[at(k)], 2e-3) << "the clamp would hide the theorem";
            sum += weights[at(k)] *
                   (vec(mesh.vertices[at(i)]) - vec(mesh.vertices[at(rings.neighbors[at(k)])]));
        }
        EXPECT_LT(largest(sum), 1e-14);
    }
}

TEST(EdgeWeights, ZeroAreaFacesAreCountedAndCarryNothing) {
    TriangleMesh mesh = kite();
    mesh.vertices.push_back({0.5, 0, 0});
    mesh.faces.push_back({0, 1, 4});  // flat on the edge 0-1
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    const EdgeWeightTable table = edge_weights(mesh, rings, EdgeWeights::cotangent);
    EXPECT_EQ(table.zero_area_faces.count, 1);
    EXPECT_EQ(table.zero_area_faces.first, 2);
    EXPECT_NEAR(weight(mesh, EdgeWeights::cotangent, 0, 1), 1 / std::sqrt(3.0), 1e-15);
    EXPECT_EQ(weight(mesh, EdgeWeights::cotangent, 0, 4), 1e-3);
}

TEST(EdgeWeights, NamesGoBothWaysAndOthersAreRefused) {
    for (const EdgeWeights kind :
         {EdgeWeights::cotangent, EdgeWeights::authors, EdgeWeights::uniform}) {
        EXPECT_EQ(parse_edge_weights(to_string(kind)), kind);
    }
    EXPECT_THROW(parse_edge_weights("cotan"), UsageError);
}

}  // namespace
}  // namespace mscomp
