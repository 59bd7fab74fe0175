// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/render/render.h"
#include "shapes.h"

namespace mscomp {
namespace {

double dot(const Point& p, const Point& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }

Point cross(const Point& p, const Point& q) {
    return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

/// The corners of a box of these extents around (3, -2, 5).
std::vector<Point> box(double x, double y, double z) {
    std::vector<Point> corners;
    for (int i = 0; i < 8; ++i) {
        corners.push_back(
            {3 + x * ((i & 1) - 0.5), -2 + y * ((i >> 1 & 1) - 0.5), 5 + z * ((i >> 2 & 1) - 0.5)});
    }
    return corners;
}

/// The coordinate axis that points up most, or towards the viewer most.
std::size_t main_axis(const Point& p) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) {
        if (std::abs(p[k]) > std::abs(p[axis])) axis = k;
    }
    return axis;
}

TEST(FitView, HasOrthonormalRightHandedAxes) {
    for (const auto& points : {box(1, 2, 3), box(9, 1, 2), box(1, 2, 9), box(1, 0, 0)}) {
        const View view = fit_view(points);
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                EXPECT_NEAR(dot(view.axes[i], view.axes[j]), i == j ? 1 : 0, 1e-12);
            }
        }
        EXPECT_NEAR(dot(cross(view.axes[0], view.axes[1]), view.axes[2]), 1, 1e-12);
    }
}

TEST(FitView, StandsThingsUp) {
    EXPECT_EQ(main_axis(fit_view(box(0.4, 1.5, 1.7)).axes[1]), 1u) << "a horse";
    EXPECT_EQ(main_axis(fit_view(box(0.4, 1.8, 1.0)).axes[1]), 1u) << "a person along y";
    EXPECT_EQ(main_axis(fit_view(box(1.8, 0.3, 1.0)).axes[1]), 0u) << "a person along x";
    EXPECT_EQ(main_axis(fit_view(box(1.0, 0.3, 1.8)).axes[1]), 2u) << "a person along z";
    for (const auto& points : {box(0.4, 1.5, 1.7), box(1.8, 0.3, 1.0), box(1.0, 0.3, 1.8)}) {
        const View view = fit_view(points);
        EXPECT_GT(view.axes[1][main_axis(view.axes[1])], 0.9) << "the right way up";
    }
}

TEST(FitView, LooksAcrossTheThinSide) {
    EXPECT_EQ(main_axis(fit_view(box(0.4, 1.5, 1.7)).axes[2]), 0u);
    EXPECT_EQ(main_axis(fit_view(box(1.8, 0.3, 1.0)).axes[2]), 1u);
    EXPECT_EQ(main_axis(fit_view(box(1.0, 1.2, 0.2)).axes[2]), 2u);
}

TEST(FitView, LooksSlightlyFromAboveAndFromTheSide) {
    const View view = fit_view(box(1.0, 1.2, 0.2));
    EXPECT_NEAR(view.axes[2][1], std::sin(12 * 3.14159265 / 180), 1e-6);
    EXPECT_NEAR(std::atan2(view.axes[2][0], view.axes[2][2]), 30 * 3.14159265 / 180, 1e-6);
}

// Every vertex lies inside the picture, and some come near its edge.
TEST(FitView, FramesAllVertices) {
    for (const double aspect : {0.5, 1.0, 1.7}) {
        for (const auto& points : {box(1, 2, 3), box(9, 1, 2), box(1e-7, 2e-7, 1e-7)}) {
            const View view = fit_view(points, aspect);
            const double half_width = view.half_extent * std::max(1.0, aspect);
            const double half_height = view.half_extent * std::max(1.0, 1 / aspect);
            double fill = 0;
            for (const Point& p : points) {
                const Point offset{p[0] - view.center[0], p[1] - view.center[1],
                                   p[2] - view.center[2]};
                fill = std::max({fill, std::abs(dot(offset, view.axes[0])) / half_width,
                                 std::abs(dot(offset, view.axes[1])) / half_height});
            }
            EXPECT_TRUE(fill <= 1) << fill;
            EXPECT_TRUE(fill >= 0.95) << fill;
        }
    }
}

TEST(FitView, TakesASinglePoint) {
    const View view = fit_view(std::vector<Point>{{1, 2, 3}});
    EXPECT_EQ(view.half_extent, 1);
    EXPECT_NEAR(view.center[2], 3, 1e-12);
}

TEST(FitView, RefusesNothing) {
    EXPECT_THROW(fit_view(std::vector<Point>{}), MeshError);
    EXPECT_THROW(fit_view(std::vector<Point>{{1, 2, std::numeric_limits<double>::infinity()}}),
                 MeshError);
}

TEST(PictureSize, FollowsTheShapeWithinReason) {
    EXPECT_EQ(picture_size(View{.aspect = 1}, 300), (std::array<int, 2>{300, 300}));
    EXPECT_EQ(picture_size(View{.aspect = 1.5}, 300), (std::array<int, 2>{300, 200}));
    EXPECT_EQ(picture_size(View{.aspect = 0.6}, 300), (std::array<int, 2>{180, 300}));
    EXPECT_EQ(picture_size(View{.aspect = 0.01}, 300), (std::array<int, 2>{150, 300}));
}

// Framing anew keeps the direction and lets every vertex fit.
TEST(Framed, KeepsTheDirectionAndHoldsEverything) {
    const std::vector<Point> upright = shapes::cylinder(12, 9, 0.5, 4, true).vertices;
    const View view = fit_view(upright);
    std::vector<Point> all = upright;
    all.push_back({30, 1, 2});
    const View wider = framed(view, all, 1.5);
    EXPECT_EQ(wider.axes, view.axes);
    for (const Point& p : all) {
        double right = 0, up = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            right += (p[k] - wider.center[k]) * wider.axes[0][k];
            up += (p[k] - wider.center[k]) * wider.axes[1][k];
        }
        EXPECT_LE(std::abs(right), 1.5 * wider.half_extent);
        EXPECT_LE(std::abs(up), wider.half_extent);
    }
}

}  // namespace
}  // namespace mscomp
