// SPDX-License-Identifier: MIT
// Nearest points of surfaces.
#include "acap/surface_tree.h"

#include <gtest/gtest.h>

#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;

// The nearest point q of a convex set to p is the one with (p - q)·(x - q) <= 0 for all x of it.
TEST(SurfaceTree, FindsTheNearestPointOfATriangle) {
    Draws draws(1);
    for (int i = 0; i < 2000; ++i) {
        const TriangleMesh triangle{
            {point(draws.vector()), point(draws.vector()), point(draws.vector())}, {{0, 1, 2}}};
        const Vector3d p = 2 * draws.vector();
        const SurfacePoint nearest = SurfaceTree(triangle).nearest(p);
        Vector3d sum = Vector3d::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector3d corner = vec(triangle.vertices[k]);
            sum += nearest.weights[static_cast<Eigen::Index>(k)] * corner;
            EXPECT_LE((p - nearest.position).dot(corner - nearest.position), 1e-12);
        }
        EXPECT_LT(largest(sum - nearest.position), 1e-14);
        EXPECT_GE(nearest.weights.minCoeff(), 0);
        EXPECT_NEAR(nearest.weights.sum(), 1, 1e-14);
        EXPECT_NEAR(nearest.square, (p - nearest.position).squaredNorm(), 1e-14);
    }
}

TEST(SurfaceTree, FindsTheNearestOfAllFaces) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const SurfaceTree tree(mesh);
    Draws draws(2);
    for (int i = 0; i < 200; ++i) {
        const Vector3d p = 2 * draws.vector(), direction = draws.vector();
        double least = 10, least_facing = 0.5;
        for (const Face& face : mesh.faces) {
            const TriangleMesh one{mesh.vertices, {face}};
            const SurfaceTree alone(one);
            const SurfacePoint nearest = alone.nearest(p);
            least = std::min(least, std::sqrt(nearest.square));
            if (alone.normal(nearest).dot(direction) <= 0) continue;
            least_facing = std::min(least_facing, std::sqrt(nearest.square));
        }
        EXPECT_EQ(std::sqrt(tree.nearest(p).square), least);
        const SurfacePoint facing = tree.nearest_facing(p, direction, 0.5);
        EXPECT_EQ(std::sqrt(facing.square), least_facing);
        EXPECT_EQ(facing.face >= 0, least_facing < 0.5);
    }
}

TEST(SurfaceTree, FacesWithoutAreaAreNoPartOfIt) {
    const TriangleMesh line{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}, {0, 0, 1}}};
    EXPECT_TRUE(SurfaceTree(line).is_empty());
    EXPECT_EQ(SurfaceTree(line).nearest({0, 0, 0}).face, -1);
}

}  // namespace
}  // namespace mscomp
