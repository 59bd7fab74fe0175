// SPDX-License-Identifier: MIT
#include "mscomp/render/overview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "shapes.h"

namespace mscomp {
namespace {

/// A square of side 2 in the plane of x and y that faces +z.
TriangleMesh plate() {
    constexpr int kSide = 41;
    TriangleMesh mesh;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) mesh.vertices.push_back({x / 20.0 - 1, y / 20.0 - 1, 0});
    }
    for (int y = 0; y + 1 < kSide; ++y) {
        for (int x = 0; x + 1 < kSide; ++x) {
            const int a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
            mesh.faces.push_back({a, b, d});
            mesh.faces.push_back({a, d, c});
        }
    }
    return mesh;
}

/// Moves what is within `radius` of `center` by up to `height` along `direction`.
std::vector<Point> bump(const TriangleMesh& mesh, const Point& center, double radius,
                        const Point& direction, double height) {
    std::vector<Point> moved = mesh.vertices;
    for (Point& p : moved) {
        const double share = 1 - square_distance(p, center) / (radius * radius);
        for (std::size_t k = 0; k < 3; ++k) p[k] += std::max(0.0, share) * height * direction[k];
    }
    return moved;
}

bool is_inside(const View& view, const Point& p) {
    const Point offset = minus(p, view.center);
    return std::abs(dot(offset, view.axes[0])) <= view.half_extent &&
           std::abs(dot(offset, view.axes[1])) <= view.half_extent;
}

TEST(Overview, SeesAPlateWithABumpFromWhereItFaces) {
    const TriangleMesh mesh = plate();
    const std::vector<ShownMotion> motions{
        {"0", -1, bump(mesh, {0.3, 0.2, 0}, 0.3, {0, 0, 1}, 0.1)}};
    const OverviewPlan plan = plan_overview(mesh, motions, {});
    EXPECT_EQ(plan.stance.front, (Point{0, 0, 1}));
    EXPECT_EQ(plan.tiles[0].viewpoint.azimuth, 0);
    EXPECT_GT(plan.tiles[0].zoom.axes[2][2], 0.9);
}

// What moves on one side of a ball is hidden from the other. 45 degrees aside may show more: there
// part of the motion is in the picture.
TEST(Overview, SeesABallFromTheSideThatMoves) {
    const TriangleMesh ball = shapes::icosphere(4);
    const std::vector<Point> sides{{0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {-1, 0, 0}, {0, 1, 0}};
    std::vector<ShownMotion> motions;
    for (const Point& side : sides) motions.push_back({"", -1, bump(ball, side, 0.6, side, 0.1)});
    const OverviewPlan plan = plan_overview(ball, motions, {});
    for (std::size_t i = 0; i < sides.size(); ++i) {
        EXPECT_GT(dot(plan.tiles[i].zoom.axes[2], sides[i]), 0.65) << i;
    }
}

TEST(Overview, FrontIsWhereMostMoves) {
    const TriangleMesh ball = shapes::icosphere(4);
    for (const Point& side : {Point{-1, 0, 0}, Point{0, 0, -1}, Point{1, 0, 0}}) {
        const std::vector<ShownMotion> motions{{"0", -1, bump(ball, side, 0.6, side, 0.1)}};
        const OverviewPlan plan = plan_overview(ball, motions, {});
        EXPECT_EQ(plan.stance.front, side);
        EXPECT_EQ(name_of(plan.tiles[0].viewpoint), "front");
    }
}

TEST(Overview, TakesTheViewAndUpThatAreAskedFor) {
    const TriangleMesh ball = shapes::icosphere(3);
    const std::vector<ShownMotion> motions{{"0", -1, bump(ball, {0, 0, 1}, 0.6, {0, 0, 1}, 0.1)}};
    OverviewOptions options;
    options.up = parse_axis("-x");
    options.view = parse_viewpoint("back");
    const OverviewPlan plan = plan_overview(ball, motions, options);
    EXPECT_FALSE(plan.is_up_guessed);
    EXPECT_NEAR(plan.tiles[0].zoom.axes[1][0], -1, 1e-12);
    EXPECT_NEAR(dot(plan.tiles[0].zoom.axes[2], plan.stance.front), -1, 1e-12);
}

TEST(Overview, SeesNoMotionBehindWhatStandsStill) {
    // Two plates; the rear one moves sideways.
    TriangleMesh mesh = plate();
    const int count = mesh.vertex_count();
    const std::size_t faces = mesh.faces.size();
    for (int v = 0; v < count; ++v) {
        Point p = mesh.vertices[at(v)];
        for (double& x : p) x *= 0.5;
        p[2] = -1;
        mesh.vertices.push_back(p);
    }
    for (std::size_t f = 0; f < faces; ++f) {
        const Face face = mesh.faces[f];
        mesh.faces.push_back({face[0] + count, face[1] + count, face[2] + count});
    }
    std::vector<Point> moved = mesh.vertices;
    for (int v = count; v < 2 * count; ++v) moved[at(v)][0] += 0.1;
    const Motion motion = motion_of(mesh.vertices, moved);
    const Stance stance;
    EXPECT_EQ(visible_motion(mesh, moved, motion, axes_from(stance, {0, 0})), 0);
    // From behind: an area of 1 that moves by 0.1 in the picture.
    EXPECT_NEAR(visible_motion(mesh, moved, motion, axes_from(stance, {180, 0})), 0.1, 0.005);
    EXPECT_EQ(visible_motion(mesh, moved, motion, axes_from(stance, {90, 0})), 0) << "edge-on";
}

TEST(Overview, MotionTowardsTheViewerCountsHalf) {
    const TriangleMesh mesh = plate();
    std::vector<Point> towards = mesh.vertices, across = mesh.vertices;
    for (Point& p : towards) p[2] += 0.1;
    for (Point& p : across) p[1] += 0.1;
    const std::array<Point, 3> axes = axes_from(Stance{}, {0, 0});
    EXPECT_NEAR(visible_motion(mesh, towards, motion_of(mesh.vertices, towards), axes), 0.2, 0.01);
    EXPECT_NEAR(visible_motion(mesh, across, motion_of(mesh.vertices, across), axes), 0.4, 0.02);
}

TEST(Overview, ZoomContainsAllThatMovesAndIsNearer) {
    const TriangleMesh mesh = plate();
    for (const double radius : {0.08, 0.2, 0.5, 3.0}) {
        const std::vector<ShownMotion> motions{
            {"0", -1, bump(mesh, {0.5, -0.4, 0}, radius, {1, 0, 1}, 0.2)}};
        const OverviewTile tile = plan_overview(mesh, motions, {}).tiles[0];
        ASSERT_FALSE(tile.motion.moving.empty());
        for (const int v : tile.motion.moving) {
            EXPECT_TRUE(is_inside(tile.zoom, mesh.vertices[at(v)])) << radius;
            EXPECT_TRUE(is_inside(tile.zoom, motions[0].moved[at(v)])) << radius;
        }
        EXPECT_EQ(tile.is_zoomed, radius < 1) << radius;
        EXPECT_GE(tile.zoom.half_extent, 0.12 * tile.whole.half_extent);
        for (const Point& p : mesh.vertices) EXPECT_TRUE(is_inside(tile.whole, p));
    }
}

TEST(Overview, MovingIsFromAQuarterOfTheLargestOn) {
    const std::vector<Point> still(4, Point{0, 0, 0});
    const Motion motion =
        motion_of(still, std::vector<Point>{{0, 0, 0}, {0, 4, 0}, {1, 0, 0}, {0, 0, 0.99}});
    EXPECT_EQ(motion.largest, 4);
    EXPECT_EQ(motion.moving, (std::vector<int>{1, 2}));
    EXPECT_TRUE(motion_of(still, still).moving.empty());
    EXPECT_THROW(motion_of(still, std::vector<Point>(3)), UsageError);
}

// One scale for all, in percent of the diagonal, which is that of a square of side 2.
TEST(Overview, ScaleEndsAtTheLargestDisplacement) {
    const TriangleMesh mesh = plate();
    const std::vector<ShownMotion> motions{{"0", -1, bump(mesh, {0, 0, 0}, 0.5, {0, 0, 1}, 0.1)},
                                           {"1", -1, bump(mesh, {0.5, 0, 0}, 0.5, {0, 0, 1}, 0.3)}};
    const OverviewPlan plan = plan_overview(mesh, motions, {});
    EXPECT_NEAR(plan.diagonal, std::sqrt(8.0), 1e-12);
    EXPECT_NEAR(plan.largest, 30 / std::sqrt(8.0), 1e-9);
    const std::vector<double> ticks = scale_ticks(plan.largest);
    EXPECT_EQ(ticks.front(), 0);
    EXPECT_EQ(ticks.back(), plan.largest);
    for (std::size_t k = 0; k < ticks.size(); ++k) {
        EXPECT_NEAR(place_on_scale(ticks[k], plan.largest), 0.25 * static_cast<double>(k), 1e-12);
    }
    EXPECT_EQ(place_on_scale(1, 0), 0);
}

TEST(Overview, KnowsWhatHardlyMoves) {
    const TriangleMesh mesh = plate();
    const auto moves = [&](double height) {
        return ShownMotion{"", -1, bump(mesh, {0, 0, 0}, 0.5, {0, 0, 1}, height)};
    };
    const std::vector<ShownMotion> motions{moves(1), moves(0.031), moves(0.029), moves(0)};
    const OverviewPlan plan = plan_overview(mesh, motions, {});
    EXPECT_FALSE(plan.tiles[0].near_empty);
    EXPECT_FALSE(plan.tiles[1].near_empty);
    EXPECT_TRUE(plan.tiles[2].near_empty);
    EXPECT_TRUE(plan.tiles[3].near_empty);
    const std::vector<ShownMotion> nothing{moves(0)};
    EXPECT_TRUE(plan_overview(mesh, nothing, {}).tiles[0].near_empty);
}

bool has_blue(const Image& sheet, int first_row, int last_row) {
    for (int i = first_row * sheet.width; i < last_row * sheet.width; ++i) {
        const auto pixel = at(i) * 3;
        if (sheet.rgb[pixel + 2] > sheet.rgb[pixel] + 30) return true;
    }
    return false;
}

// One picture below the other: the second is greyed.
TEST(Overview, GreysWhatHardlyMoves) {
    const TriangleMesh mesh = plate();
    const std::vector<ShownMotion> motions{{"", -1, bump(mesh, {0, 0, 0}, 0.5, {0, 0, 1}, 0.1)},
                                           {"", -1, bump(mesh, {0, 0, 0}, 0.5, {0, 0, 1}, 0.0029)}};
    OverviewOptions options;
    options.columns = 1;
    const Image sheet =
        draw_overview(mesh, motions, plan_overview(mesh, motions, options), options);
    const int bottom = sheet.height, step = options.tile + 30;
    EXPECT_TRUE(has_blue(sheet, bottom - 2 * step, bottom - step - 40));
    EXPECT_FALSE(has_blue(sheet, bottom - step + 10, bottom));
}

TEST(Overview, IsTheSameForAnyNumberOfThreads) {
    const TriangleMesh ball = shapes::icosphere(3);
    std::vector<ShownMotion> motions{{"0", -1, bump(ball, {0, 0, 1}, 0.6, {0, 0, 1}, 0.1)},
                                     {"1", -1, bump(ball, {1, 0, 0}, 0.6, {0, 1, 0}, 0.2)},
                                     {"0.0", 0, bump(ball, {0, 1, 0}, 0.3, {0, 1, 1}, 0.05)},
                                     {"0.1", 0, {}},
                                     {"0.1.0", 3, bump(ball, {0, -1, 0}, 0.4, {1, 0, 1}, 0.002)}};
    OverviewOptions options;
    options.title = "Components";
    options.tile = 80;
    const auto draw = [&](int threads) {
        set_thread_count(threads);
        return draw_overview(ball, motions, plan_overview(ball, motions, options), options);
    };
    const Image first = draw(1);
    EXPECT_EQ(draw(2).rgb, first.rgb);
    EXPECT_EQ(draw(7).rgb, first.rgb);
    set_thread_count(0);
}

TEST(Overview, StandsWithoutComponentsAndRefusesWhatDoesNotFit) {
    const TriangleMesh mesh = plate();
    const OverviewPlan plan = plan_overview(mesh, {}, {});
    EXPECT_GT(draw_overview(mesh, {}, plan, {}).width, 0);
    const std::vector<ShownMotion> short_one{{"0", -1, std::vector<Point>(3)}};
    EXPECT_THROW(plan_overview(mesh, short_one, {}), UsageError);
    const std::vector<ShownMotion> orphan{{"0", 5, mesh.vertices}};
    EXPECT_THROW(plan_overview(mesh, orphan, {}), UsageError);
    EXPECT_THROW(plan_overview(TriangleMesh{}, {}, {}), MeshError);
}

}  // namespace
}  // namespace mscomp
