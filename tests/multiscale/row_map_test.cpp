// SPDX-License-Identifier: MIT
// Rows of shapes and what components are made of, there and back.
#include "multiscale/row_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "ball_cases.h"
#include "mscomp/acap/alignment.h"

namespace mscomp {
namespace {

/// One shape in memory.
class OneShape final : public ShapeSet {
  public:
    explicit OneShape(const std::vector<Point>& points) {
        for (std::size_t i = 0; i < 3 * points.size(); ++i) {
            vertices_.push_back(static_cast<float>(points[i / 3][i % 3]));
        }
        for (std::size_t i = 0; i < 9 * points.size(); ++i) {
            features_.push_back(kReferenceFeature[i % 9] + static_cast<float>(i % 7) / 8);
        }
    }
    int shape_count() const override { return 1; }
    int vertex_count() const override { return static_cast<int>(vertices_.size() / 3); }
    std::span<const float> shape(int) const override { return features_; }
    std::span<const float> vertices(int) const override { return vertices_; }
    void forget(int) const override {}

  private:
    std::vector<float> vertices_, features_;
};

std::vector<Point> lifted(std::vector<Point> points, double size) {
    for (std::size_t v = 0; v < points.size() / 4; ++v) points[v][1] += 0.3 * size;
    return points;
}

RigidMotion some_motion() {
    RigidMotion motion;
    motion.rotation =
        Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    motion.translation = {0.2, -0.1, 0.3};
    return motion;
}

// A quarter of the vertices moves, wherever the shape lies and whatever its unit: these change by
// what they move, as a part of the radius, the others not at all.
TEST(RowMap, OfPositionsIsTheChangeOfWhatDoesNotRest) {
    for (const double size : {1e-6, 1.0, 1e6}) {
        TriangleMesh mesh = shapes::icosphere(2);
        for (Point& p : mesh.vertices) {
            for (double& x : p) x *= size;
        }
        const RowMap map(mesh);
        EXPECT_EQ(map.rows(), ShapeRows::positions);
        EXPECT_EQ(map.width(), 3);
        EXPECT_NEAR(map.unit(), size, 1e-6 * size);
        RigidMotion motion = some_motion();
        motion.translation *= size;
        const OneShape shape(moved(lifted(mesh.vertices, size), motion));
        const std::vector<float> row = map.mapped(shape, 0);
        ASSERT_EQ(row.size(), 3 * mesh.vertices.size());
        for (std::size_t i = 0; i < row.size(); ++i) {
            const bool has_moved = i / 3 < mesh.vertices.size() / 4 && i % 3 == 1;
            ASSERT_NEAR(row[i], has_moved ? 0.3 : 0, 1e-5) << i << " of size " << size;
        }
    }
}

TEST(RowMap, ComesBackAndIsZeroAtTheReference) {
    cases::Sphere sphere;
    for (Point& p : sphere.mesh.vertices) {
        for (double& x : p) x *= 3;
    }
    for (const RowMap& map : {RowMap(sphere.scale), RowMap(sphere.mesh)}) {
        const auto width = at(map.width());
        std::vector<float> rest(at(sphere.vertices()) * width, 0.0F);
        map.unmap(rest);
        const bool is_features = map.rows() == ShapeRows::features;
        for (std::size_t i = 0; i < rest.size(); ++i) {
            EXPECT_EQ(rest[i], is_features
                                   ? kReferenceFeature[i % 9]
                                   : static_cast<float>(sphere.mesh.vertices[i / 3][i % 3]));
        }
        const OneShape shape(lifted(sphere.mesh.vertices, 3));
        const std::vector<float> mapped = map.mapped(shape, 0);
        std::vector<float> row = mapped;
        map.unmap(row);
        const auto wanted = is_features ? shape.shape(0) : shape.vertices(0);
        for (std::size_t i = 0; i < row.size(); ++i) {
            EXPECT_NEAR(row[i], wanted[i], 1e-5);
            std::vector<float> change(width, 0.0F);
            change[i % width] = mapped[i];
            map.unmap_change(static_cast<int>(i / width), change);
            EXPECT_NEAR(change[i % width], row[i] - rest[i], 1e-5);
            EXPECT_NEAR(change[i % width] * map.factor(static_cast<int>(i / width), i % width),
                        mapped[i], 1e-5);
        }
    }
}

}  // namespace
}  // namespace mscomp
