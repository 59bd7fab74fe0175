// SPDX-License-Identifier: MIT
// Meshes of components lie where what they leave alone stays.
#include "mscomp/run/component_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mscomp/acap/extract.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "shapes.h"

namespace mscomp {
namespace {

/// Two closed bars beside each other, along z from 0 to 4.
TriangleMesh two_bars() {
    const TriangleMesh bar = shapes::cylinder(12, 33, 0.4, 4.0, true);
    TriangleMesh both = bar;
    for (const Point& p : bar.vertices) both.vertices.push_back({p[0] + 3, p[1], p[2]});
    for (const Face& f : bar.faces) {
        const int n = bar.vertex_count();
        both.faces.push_back({f[0] + n, f[1] + n, f[2] + n});
    }
    return both;
}

/// The bar at x = 0 turned by up to `angle` around the y axis above z = `from`, the other one left.
std::vector<Point> bent(const TriangleMesh& bars, double from, double angle) {
    std::vector<Point> vertices = bars.vertices;
    for (Point& p : vertices) {
        if (p[0] > 1.5 || p[2] <= from) continue;
        const double turn = angle * std::min(1.0, p[2] - from), height = p[2] - from;
        p = {std::cos(turn) * p[0] + std::sin(turn) * height, p[1],
             from - std::sin(turn) * p[0] + std::cos(turn) * height};
    }
    return vertices;
}

class ComponentMeshesTest : public testing::Test {
  protected:
    ComponentMeshesTest() { context_.reference = two_bars(); }

    /// Features of a shape minus those of the reference, exactly zero where they are so but for
    /// rounding.
    std::vector<float> change_of(const std::vector<Point>& vertices) const {
        MeshSequence sequence;
        sequence.faces = context_.reference.faces;
        sequence.names = {"bent"};
        sequence.shapes = {vertices};
        ExtractOptions options;
        options.align = false;
        std::vector<float> change =
            extract_features(sequence, context_.reference.vertices, options).features;
        for (std::size_t i = 0; i < change.size(); ++i) {
            change[i] -= kReferenceFeature[i % kFeatureDim];
            if (std::abs(change[i]) < 1e-6F) change[i] = 0;
        }
        return change;
    }
    double largest_difference(const std::vector<Point>& a, const std::vector<Point>& b) const {
        double largest = 0;
        for (std::size_t v = 0; v < a.size(); ++v) {
            for (std::size_t i = 0; i < 3; ++i) {
                const double difference = std::abs(a[v][i] - b[v][i]);
                if (!(difference <= largest)) largest = difference;
            }
        }
        return largest;
    }

    ModelContext context_;
};

// The lower half of the bar stays, so the mesh of the features of a bent bar is the bent bar, where
// it lay; its centroid does not stay.
TEST_F(ComponentMeshesTest, LiesWhereItsLargestStillPieceLay) {
    const std::vector<Point> shape = bent(context_.reference, 2.5, 1.2);
    const TriangleMesh mesh = ComponentMeshes(context_, ShapeRows::features).mesh(change_of(shape));
    EXPECT_LT(largest_difference(mesh.vertices, shape), 1e-4);
}

// Bent in the lower half, the upper part turns as one: features change everywhere above, so the
// short piece below is what stays, not the middle of all.
TEST_F(ComponentMeshesTest, StaysOnAPieceThatIsLessThanHalf) {
    const std::vector<Point> shape = bent(context_.reference, 1.0, 1.2);
    const TriangleMesh mesh = ComponentMeshes(context_, ShapeRows::features).mesh(change_of(shape));
    EXPECT_LT(largest_difference(mesh.vertices, shape), 1e-4);
}

// A step to the side leaves both ends of the bar alone: the longer one stays.
TEST_F(ComponentMeshesTest, OfTwoStillPiecesTheLargerOneStays) {
    for (const double from : {1.0, 2.5}) {
        std::vector<Point> shape = context_.reference.vertices;
        for (Point& p : shape) {
            if (p[0] > 1.5) continue;
            const double above = 0.3 * std::clamp(2 * (p[2] - from), 0.0, 1.0);
            p[0] += from < 2 ? above - 0.3 : above;
        }
        const TriangleMesh mesh =
            ComponentMeshes(context_, ShapeRows::features).mesh(change_of(shape));
        EXPECT_LT(largest_difference(mesh.vertices, shape), 1e-4) << from;
    }
}

// Where every vertex changes the median of all displacements is zero, and both bars grow as one.
TEST_F(ComponentMeshesTest, ThatChangesEverywhereKeepsItsMedian) {
    std::vector<Point> larger = context_.reference.vertices;
    for (Point& p : larger) p = {1.1 * p[0], 1.1 * p[1], 1.1 * p[2]};
    const TriangleMesh mesh =
        ComponentMeshes(context_, ShapeRows::features).mesh(change_of(larger));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> moves;
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
            moves.push_back(mesh.vertices[v][axis] - context_.reference.vertices[v][axis]);
        }
        std::ranges::sort(moves);
        EXPECT_NEAR(moves[moves.size() / 2], 0, 1e-9);
        EXPECT_GT(moves.back() - moves.front(), 0.07);
    }
}

// Colour runs to the 98th percentile of what moves, nothing at all gives no blue.
TEST_F(ComponentMeshesTest, IsColouredByTheChange) {
    const ComponentMeshes shapes(context_, ShapeRows::features);
    std::vector<float> change(context_.reference.vertices.size() * 9, 0.0F);
    EXPECT_EQ(shapes.colored(change).full_blue, 0.0F);
    for (std::size_t v = 0; v < 101; ++v) {
        change[v * 9] = 0.003F * static_cast<float>(v + 1);
        change[v * 9 + 1] = 0.004F * static_cast<float>(v + 1);
    }
    const ColoredShape shape = shapes.colored(change);
    EXPECT_NEAR(shape.amount[10], 0.055F, 1e-6F);
    EXPECT_EQ(shape.amount[101], 0.0F);
    EXPECT_NEAR(shape.full_blue, 0.005F * 99, 1e-6F);
}

TEST_F(ComponentMeshesTest, DisplacementIsTheDistanceOfEachVertex) {
    TriangleMesh mesh = context_.reference;
    mesh.vertices[3][0] += 3;
    mesh.vertices[3][2] -= 4;
    const std::vector<float> moved =
        ComponentMeshes(context_, ShapeRows::features).displacement(mesh);
    EXPECT_FLOAT_EQ(moved[3], 5.0F);
    EXPECT_EQ(std::ranges::count(moved, 0.0F), static_cast<std::ptrdiff_t>(moved.size()) - 1);
}

}  // namespace
}  // namespace mscomp
