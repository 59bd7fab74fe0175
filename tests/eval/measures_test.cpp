// SPDX-License-Identifier: MIT
#include "mscomp/eval/measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "shapes.h"

namespace mscomp {
namespace {

std::vector<Point> turned_and_moved(const std::vector<Point>& points) {
    std::vector<Point> result;
    for (const Point& p : points) result.push_back({3 - p[1], p[0] - 1, p[2] + 0.5});
    return result;
}

std::vector<Point> times(const std::vector<Point>& points, double factor) {
    std::vector<Point> result;
    for (const Point& p : points) result.push_back({factor * p[0], factor * p[1], factor * p[2]});
    return result;
}

// E_rms does not see rigid motions.
TEST(RmsError, OfARigidMotionIsZero) {
    const std::vector<Point> sphere = shapes::icosphere(2).vertices;
    RmsError error(sphere);
    error.add(sphere, turned_and_moved(sphere));
    EXPECT_NEAR(error.value(), 0, 1e-9);
}

// A mirrored shape is no rigid motion of itself.
TEST(RmsError, SeesAMirrorImage) {
    std::vector<Point> shape = shapes::icosphere(1).vertices;
    for (Point& p : shape) p = {p[0] * (1 + 0.5 * p[1]), 2 * p[1], 3 * p[2] + p[0] * p[0]};
    std::vector<Point> mirrored = shape;
    for (Point& p : mirrored) p[0] = -p[0];
    RmsError error(shape);
    error.add(shape, mirrored);
    EXPECT_GT(error.value(), 10);
}

// Scaling a unit sphere by 1.1 moves every vertex by 0.1: 1000 * 0.1 / sqrt(3).
TEST(RmsError, OfAScaledUnitSphereIsKnown) {
    const std::vector<Point> sphere = shapes::icosphere(2).vertices;
    std::vector<Point> larger = sphere;
    for (Point& p : larger) p = {1.1 * p[0], 1.1 * p[1], 1.1 * p[2]};
    RmsError error(sphere);
    error.add(sphere, larger);
    EXPECT_NEAR(error.value(), 100 / std::sqrt(3.0), 1e-9);
    error.add(sphere, sphere);  // pooled with a perfect shape: divided by sqrt(2)
    EXPECT_NEAR(error.value(), 100 / std::sqrt(6.0), 1e-9);
}

// The unit of the meshes does not matter.
TEST(RmsError, IsIndependentOfTheUnit) {
    std::vector<Point> sphere = shapes::icosphere(1).vertices, other = sphere;
    for (Point& p : other) p[0] *= 1.2;
    RmsError small(sphere);
    small.add(sphere, other);
    for (auto* shape : {&sphere, &other}) {
        for (Point& p : *shape) p = {1000 * p[0], 1000 * p[1], 1000 * p[2]};
    }
    RmsError large(sphere);
    large.add(sphere, other);
    EXPECT_NEAR(large.value(), small.value(), 1e-9 * small.value());
}

TEST(RmsError, RefusesDifferentNumbersOfVertices) {
    const std::vector<Point> sphere = shapes::icosphere(1).vertices;
    RmsError error(sphere);
    EXPECT_THROW(error.add(sphere, shapes::icosphere(0).vertices), MeshError);
    EXPECT_TRUE(std::isnan(error.value()));
}

// Each shape alone, then pooled: 100 / sqrt(3) and 200 / sqrt(3) give sqrt((1 + 4) / 2) 100 /
// sqrt(3).
TEST(RmsError, TellsTheErrorOfEachShape) {
    const std::vector<Point> sphere = shapes::icosphere(2).vertices;
    RmsError error(sphere);
    EXPECT_NEAR(error.add(sphere, times(sphere, 1.1)), 100 / std::sqrt(3.0), 1e-9);
    EXPECT_NEAR(error.add(sphere, times(sphere, 1.2)), 200 / std::sqrt(3.0), 1e-9);
    EXPECT_NEAR(error.value(), 100 * std::sqrt(2.5 / 3), 1e-9);
    EXPECT_EQ(error.shape_count(), 2);
}

// A ball of radius 3 away from the origin becomes one of radius 1.
TEST(UnitBallScale, IsOneOverTheRadiusAroundTheCentroid) {
    std::vector<Point> ball = times(shapes::icosphere(1).vertices, 3);
    for (Point& p : ball) p[1] += 17;
    EXPECT_NEAR(unit_ball_scale(ball), 1.0 / 3, 1e-12);
}

// Never 0 or infinite: an error times such a scale would look perfect or be no number by accident.
TEST(UnitBallScale, OfNoBallIsNaN) {
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_TRUE(std::isnan(unit_ball_scale({})));
    EXPECT_TRUE(std::isnan(unit_ball_scale({{1, 2, 3}, {1, 2, 3}})));
    EXPECT_TRUE(std::isnan(unit_ball_scale({{1, 2, 3}, {1, infinity, 3}, {0, 0, 0}})));
    // The square of its radius is more than a double can hold.
    EXPECT_TRUE(std::isnan(unit_ball_scale({{1e200, 2, 3}, {-1e200, 2, 3}})));
    EXPECT_TRUE(std::isnan(unit_ball_scale({{1, std::nan(""), 3}, {1, 4, 3}})));
}

// A sphere of radius 2 and one of 2.5, turned and moved: every vertex is 0.5 away.
TEST(VertexDistances, AreInTheUnitOfTheInput) {
    const std::vector<Point> sphere = shapes::icosphere(1).vertices;
    const std::vector<double> distances =
        vertex_distances(times(sphere, 2), turned_and_moved(times(sphere, 2.5)));
    ASSERT_EQ(distances.size(), sphere.size());
    for (const double distance : distances) EXPECT_NEAR(distance, 0.5, 1e-12);
}

TEST(VertexDistances, RefuseDifferentNumbersOfVertices) {
    EXPECT_THROW(vertex_distances({{0, 0, 0}}, {}), MeshError);
    EXPECT_THROW(vertex_distances({}, {}), MeshError);
}

// [A] eq. 8: |X - Y|^2 / |X|^2.
TEST(RelativeSquaredError, IsTheRatioOfSquares) {
    const std::vector<float> x{3, 4}, y{3, 2}, zero{0, 0};
    EXPECT_DOUBLE_EQ(relative_squared_error(x, y), 4.0 / 25);
    EXPECT_DOUBLE_EQ(relative_squared_error(x, x), 0);
    EXPECT_EQ(relative_squared_error(zero, x), std::numeric_limits<double>::infinity());
    EXPECT_EQ(relative_squared_error(zero, zero), 0);
}

}  // namespace
}  // namespace mscomp
