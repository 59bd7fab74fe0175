// SPDX-License-Identifier: MIT
#include "mscomp/eval/farthest_points.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "moved_shapes.h"
#include "mscomp/base/error.h"
#include "shapes.h"

namespace mscomp {
namespace {

/// Points on the x axis; the centroid of these is 4.
std::vector<Point> on_axis(const std::vector<double>& places) {
    std::vector<Point> points;
    for (const double x : places) points.push_back({x, 0, 0});
    return points;
}

// Centroid 4: 11 is farthest (7 away). Then 0 (11 away); then 6 (5 from 11), 2 (2 from 0, 4 from
// 6), 1 last.
TEST(FarthestPoints, AgreeWithAnExampleByHand) {
    EXPECT_EQ(farthest_point_samples(on_axis({1, 11, 2, 0, 6}), 5),
              (std::vector<int>{1, 3, 4, 2, 0}));
}

TEST(FarthestPoints, TakeTheLowestIndexOfEquals) {
    const std::vector<Point> square{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    EXPECT_EQ(farthest_point_samples(square, 4), (std::vector<int>{0, 2, 1, 3}));
    // All at one place: one after the other, none twice.
    EXPECT_EQ(farthest_point_samples(on_axis({2, 2, 2}), 3), (std::vector<int>{0, 1, 2}));
}

// The definition: each next one maximises the distance to the nearest before it.
TEST(FarthestPoints, EachIsTheFarthestFromThoseBefore) {
    const std::vector<Point> points = noisy(shapes::icosphere(2).vertices, 0.1, 3);
    const std::vector<int> samples = farthest_point_samples(points, 20);
    const auto gap = [&](std::size_t vertex, std::size_t count) {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t m = 0; m < count; ++m) {
            const Point& q = points[static_cast<std::size_t>(samples[m])];
            nearest =
                std::min(nearest, std::hypot(points[vertex][0] - q[0], points[vertex][1] - q[1],
                                             points[vertex][2] - q[2]));
        }
        return nearest;
    };
    for (std::size_t m = 1; m < samples.size(); ++m) {
        const double taken = gap(static_cast<std::size_t>(samples[m]), m);
        for (std::size_t v = 0; v < points.size(); ++v) EXPECT_LE(gap(v, m), taken + 1e-12);
    }
    EXPECT_EQ(std::set<int>(samples.begin(), samples.end()).size(), samples.size());
}

TEST(FarthestPoints, OfFewerAreTheFirstOfMore) {
    const std::vector<Point> points = noisy(shapes::icosphere(1).vertices, 0.1, 3);
    std::vector<int> more = farthest_point_samples(points, 12);
    more.resize(5);
    EXPECT_EQ(farthest_point_samples(points, 5), more);
    EXPECT_TRUE(farthest_point_samples(points, 0).empty());
    EXPECT_EQ(farthest_point_samples(points, static_cast<int>(points.size())).size(),
              points.size());
}

TEST(FarthestPoints, DoNotDependOnPlaceUnitOrNumbers) {
    const std::vector<Point> points = noisy(shapes::icosphere(1).vertices, 0.1, 3);
    const std::vector<int> samples = farthest_point_samples(points, 10);
    EXPECT_EQ(farthest_point_samples(placed(points, 1.7), 10), samples);
    EXPECT_EQ(farthest_point_samples(placed(points, 0, 1e4), 10), samples);
    const std::vector<int> order = CounterRandom(5, 0).permutation(static_cast<int>(points.size()));
    std::vector<int> wanted;
    for (const int sample : samples) wanted.push_back(order[static_cast<std::size_t>(sample)]);
    EXPECT_EQ(farthest_point_samples(renumbered(points, order), 10), wanted);
}

TEST(FarthestPoints, RefuseMoreThanThereAreAndWhatIsNotFinite) {
    EXPECT_THROW(farthest_point_samples(on_axis({0, 1}), 3), UsageError);
    EXPECT_THROW(farthest_point_samples(on_axis({0, 1}), -1), UsageError);
    EXPECT_THROW(
        farthest_point_samples(on_axis({0, std::numeric_limits<double>::quiet_NaN(), 1}), 2),
        MeshError);
}

}  // namespace
}  // namespace mscomp
