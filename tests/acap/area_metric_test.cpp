// SPDX-License-Identifier: MIT
#include "mscomp/acap/area_metric.h"

#include <gtest/gtest.h>

#include "shapes.h"

namespace mscomp {
namespace {

double mean_square(const std::vector<float>& roots) {
    double sum = 0;
    for (const float s : roots) sum += static_cast<double>(s) * static_cast<double>(s);
    return sum / static_cast<double>(roots.size());
}

// A square of four corners, by hand: the two at the diagonal have two of its six thirds each.
TEST(AreaMetric, IsAThirdOfTheTrianglesAround) {
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    const std::vector<float> roots = area_metric(mesh);
    EXPECT_NEAR(roots[0] * roots[0], 4.0 / 3, 1e-6);
    EXPECT_NEAR(roots[1] * roots[1], 2.0 / 3, 1e-6);
    EXPECT_NEAR(mean_square(roots), 1, 1e-6);
}

// However small the triangles around a vertex, it counts a fiftieth of the mean.
TEST(AreaMetric, HasAFloor) {
    TriangleMesh mesh = shapes::icosphere(2);
    const auto tip = mesh.vertices.size();
    for (const double x : {0.0, 1e-6, 2e-6}) mesh.vertices.push_back({x, x * x, 3});
    mesh.vertices.push_back({5, 5, 5});  // without a face
    const int first = static_cast<int>(tip);
    mesh.faces.push_back({first, first + 1, first + 2});
    const std::vector<float> roots = area_metric(mesh);
    EXPECT_NEAR(mean_square(roots), 1, 1e-6);
    for (std::size_t v = tip; v < roots.size(); ++v) {
        EXPECT_NEAR(roots[v] * roots[v], 0.02, 0.001) << v;
    }
}

TEST(AreaMetric, OfAMeshWithoutAreaIsTheSameEverywhere) {
    TriangleMesh mesh;
    mesh.vertices = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    mesh.faces = {{0, 1, 2}};
    for (const float root : area_metric(mesh)) EXPECT_EQ(root, 1.0F);
}

}  // namespace
}  // namespace mscomp
