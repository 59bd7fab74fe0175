// SPDX-License-Identifier: MIT
// Components of another model as components to begin with.
#include "multiscale/given_balls.h"

#include <gtest/gtest.h>

#include "ball_cases.h"
#include "mscomp/base/error.h"
#include "multiscale/code_columns.h"

namespace mscomp {
namespace {

/// What another model would say of these components.
GivenComponents given_of(const BallComponents& components, const MetricScale& scale) {
    GivenComponents given{
        components.vertex_count(), {{1, 2}, {2, 3}}, std::vector<int>(8, -1), {}, {}};
    given.changes = code_columns(components, RowMap(scale));
    for (const Ball& ball : components.balls()) given.centers.push_back(ball.center);
    return given;
}

MultiscaleSettings settings_for(int global, std::vector<int> counts) {
    MultiscaleSettings settings;
    settings.global_components = global;
    settings.levels.clear();
    for (const int count : counts) settings.levels.push_back({count, 1, 1});
    return settings;
}

// There and back: the same components, however long they are.
TEST(GivenBalls, AreTheComponentsAtUnitLength) {
    cases::Sphere sphere;
    const BallComponents components = sphere.components(8, 0.3);
    GivenComponents given = given_of(components, sphere.scale);
    for (float& x : given.changes[3].values) x *= 7;
    const BallComponents again = given_balls(given, RowMap(sphere.scale));
    EXPECT_LT((cases::dense(again) - cases::dense(components)).norm(), 1e-5);
    for (int k = 0; k < 8; ++k) {
        EXPECT_EQ(again.balls()[at(k)].vertices, components.balls()[at(k)].vertices);
        EXPECT_EQ(again.balls()[at(k)].center, components.balls()[at(k)].center);
    }
}

// Levels count as they are decoded: every autoencoder's components, the global ones first.
TEST(GivenBalls, WantTheLevelsThatTheyHave) {
    cases::Sphere sphere;
    const GivenComponents given = given_of(sphere.components(8, 0.3), sphere.scale);
    EXPECT_NO_THROW(require_levels(given, settings_for(0, {2, 6})));
    EXPECT_NO_THROW(require_levels(given, settings_for(2, {6})));
    for (const auto& settings :
         {settings_for(0, {2, 3}), settings_for(0, {8}), settings_for(0, {6, 2}),
          settings_for(2, {2, 6}), settings_for(1, {7})}) {
        EXPECT_THROW(require_levels(given, settings), UsageError);
    }
}

TEST(GivenBalls, LieInTheLevelsAroundThem) {
    cases::Sphere sphere;
    const GivenComponents given = given_of(sphere.components(8, 0.3), sphere.scale);
    const std::vector<BallLevel> levels = levels_around(given, sphere.distances);
    ASSERT_EQ(levels.size(), 2U);
    EXPECT_EQ(levels[0].components, 2);
    EXPECT_EQ(levels[1].components, 6);
    for (const BallLevel& level : levels) {
        EXPECT_GT(level.sparsity_range, 0.2);
        EXPECT_LE(level.sparsity_range, 0.3 + 1e-12);
        EXPECT_GT(level.max_support, 0.02);
        EXPECT_LT(level.max_support, 0.3);
    }
}

// Nothing at all is a thousandth: no level has a range or a share of nothing.
TEST(GivenBalls, ComponentsOfNothingHaveALevelToo) {
    cases::Sphere sphere;
    GivenComponents given{sphere.vertices(), {{1, 1}}, {-1}, {5}, {{}}};
    const std::vector<BallLevel> levels = levels_around(given, sphere.distances);
    EXPECT_EQ(levels.front().max_support, 0.001);
    EXPECT_EQ(given_balls(given, RowMap(sphere.scale)).component(0).size(), 0U);
}

}  // namespace
}  // namespace mscomp
