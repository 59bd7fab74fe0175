// SPDX-License-Identifier: MIT
#include "acap/reconstruct/whitened_descent.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Three free vertices beside an anchor, joined by the matrix.
AnchoredSystem metric_of(const Matrix3d& a) {
    MatrixEntries entries;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j <= i; ++j) entries.emplace_back(i + 1, j + 1, a(i, j));
    }
    return {entries, 4, {0}, "a metric"};
}

Matrix3d some_matrix() {
    Matrix3d a;
    a << 4, 1, 0, 1, 3, -1, 0, -1, 2;
    return a;
}

/// One coordinate of the free vertices.
Vector3d column(const std::vector<Point>& points, std::size_t axis) {
    return {points[1][axis], points[2][axis], points[3][axis]};
}

/// Σ (x - goal)ᵀ A (x - goal) over the three coordinates, whatever the anchor does.
double parabola(const Matrix3d& a, const Matrix3d& goal, const std::vector<Point>& points,
                std::vector<Point>& derivative) {
    derivative.assign(4, Point{7, 7, 7});
    double value = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Vector3d away = column(points, axis) - goal.col(static_cast<Eigen::Index>(axis));
        const Vector3d slope = 2 * a * away;
        for (int i = 0; i < 3; ++i) derivative[static_cast<std::size_t>(i) + 1][axis] = slope[i];
        value += away.dot(a * away);
    }
    return value;
}

// (x - c)ᵀ A (x - c) with the metric A: the first step leads to c, in any unit.
TEST(WhitenedDescent, FindsTheMinimumOfAParabolaInOneStepGivenItsMatrix) {
    const Matrix3d a = some_matrix();
    for (const double unit : {1e-4, 1.0, 1e4}) {
        Matrix3d goal;
        goal << 1, -2, 5, 0.5, 3, -1, 2, 2, -4;
        goal *= unit;
        std::vector<Point> x(4, Point{});
        x[0] = {1, 2, 3};
        DescentOptions options;
        options.largest_step = 1e-12 * unit;
        options.least_gain = 0;
        const DescentResult found =
            descend([&](const std::vector<Point>& p,
                        std::vector<Point>& slope) { return parabola(a, goal, p, slope); },
                    metric_of(a), x, options);
        EXPECT_TRUE(found.converged);
        EXPECT_LE(found.steps, 2);
        EXPECT_EQ(x[0], (Point{1, 2, 3})) << "the anchor";
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_LE((column(x, axis) - goal.col(static_cast<Eigen::Index>(axis))).norm(),
                      1e-10 * unit);
        }
    }
}

// With the metric of something else it takes more steps, and gets there.
TEST(WhitenedDescent, FindsTheMinimumOfAParabolaInAnotherMetric) {
    const Matrix3d a = some_matrix(), goal = Matrix3d::Constant(3);
    std::vector<Point> x(4, Point{});
    DescentOptions options;
    options.largest_step = 1e-10;
    options.least_gain = 0;
    const DescentResult found =
        descend([&](const std::vector<Point>& p,
                    std::vector<Point>& slope) { return parabola(a, goal, p, slope); },
                metric_of(Matrix3d::Identity() * 9), x, options);
    EXPECT_GT(found.steps, 2);
    EXPECT_LE(found.value, 1e-16);
}

AnchoredSystem metric_of_one_vertex(double value) {
    return {MatrixEntries{{1, 1, value}}, 2, {0}, "a metric"};
}

// Rosenbrock's valley, minimum 0 at (1, 1).
double valley(const std::vector<Point>& p, std::vector<Point>& slope) {
    const double u = 1 - p[1][0], v = p[1][1] - p[1][0] * p[1][0];
    slope.assign(2, Point{});
    slope[1] = {-2 * u - 400 * p[1][0] * v, 200 * v, 0};
    return u * u + 100 * v * v;
}

// From the usual start and with no idea of its Hessian.
TEST(WhitenedDescent, FollowsACurvedValley) {
    std::vector<Point> x{{}, {-1.2, 1, 0}};
    DescentOptions options;
    options.largest_step = 1e-10;
    options.least_gain = 0;
    options.max_evaluations = 500;
    const DescentResult found = descend(valley, metric_of_one_vertex(500), x, options);
    EXPECT_LE(found.value, 1e-12);
    EXPECT_LE(std::hypot(x[1][0] - 1, x[1][1] - 1), 1e-5);
}

TEST(WhitenedDescent, StopsAfterSoManyEvaluations) {
    int evaluations = 0;
    const auto f = [&](const std::vector<Point>& p, std::vector<Point>& slope) {
        ++evaluations;
        return valley(p, slope);
    };
    std::vector<Point> x{{}, {-1.2, 1, 0}}, slope;
    const double start = valley(x, slope);
    DescentOptions options;
    options.max_evaluations = 5;
    const DescentResult found = descend(f, metric_of_one_vertex(500), x, options);
    EXPECT_FALSE(found.converged);
    EXPECT_LT(found.value, start);
    EXPECT_EQ(found.value, valley(x, slope));
    EXPECT_LE(evaluations, 5 + 20) << "a search along a line that was begun may end";
}

// At the minimum there is nothing to do.
TEST(WhitenedDescent, KnowsAMinimum) {
    const auto f = [](const std::vector<Point>& p, std::vector<Point>& slope) {
        slope.assign(2, Point{});
        slope[1][0] = 2 * p[1][0];
        return 1 + p[1][0] * p[1][0];
    };
    std::vector<Point> x{{}, {}};
    const DescentResult found = descend(f, metric_of_one_vertex(1), x, {});
    EXPECT_TRUE(found.converged);
    EXPECT_EQ(found.steps, 0);
    EXPECT_EQ(x[1], Point{});
}

// A function that only looks like a descent: the value never rises, and the end is honest.
TEST(WhitenedDescent, StopsUnconvergedWhereTheDerivativeIsWrong) {
    const auto f = [](const std::vector<Point>& p, std::vector<Point>& slope) {
        slope.assign(2, Point{-1, -1, -1});
        return 1 + std::abs(p[1][0]);
    };
    std::vector<Point> x{{}, {}};
    const DescentResult found = descend(f, metric_of_one_vertex(0.5), x, {});
    EXPECT_FALSE(found.converged);
    EXPECT_EQ(found.value, 1);
    EXPECT_EQ(x[1], Point{});
}

}  // namespace
}  // namespace mscomp
