// SPDX-License-Identifier: MIT
#include "multiscale/ball_start.h"

#include <gtest/gtest.h>

#include "ball_cases.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

MultiscaleSettings small_settings() {
    MultiscaleSettings settings;
    settings.global_components = 2;
    settings.levels = {{4, 0.4, 0.3}, {20, 0.2, 0.1}};
    settings.spread = {2, 0.15};
    return settings;
}

class BallStart : public testing::Test {
  protected:
    BallComponents start(const MultiscaleSettings& settings) {
        const MetricRows rows = cases::rows_of(cases::random_matrix(9 * sphere_.vertices(), 40, 1));
        return start_balls(rows, settings, sphere_.distances);
    }
    cases::Sphere sphere_;
};

// Balls are within the range and hold no more than the share of their level; what is not zero lies
// inside, with unit length. Global ones reach everything.
TEST_F(BallStart, FindsComponentsWithinReach) {
    const MultiscaleSettings settings = small_settings();
    const BallComponents components = start(settings);
    ASSERT_EQ(components.count(), 26);
    const MatrixXd C = cases::dense(components);
    for (int k = 0; k < components.count(); ++k) {
        EXPECT_NEAR(C.col(k).norm(), 1, 1e-5) << k;
        const Ball& ball = components.balls()[at(k)];
        if (k < 2) {
            EXPECT_EQ(ball.vertices.size(), at(sphere_.vertices()));
            continue;
        }
        const BallLevel& level = settings.levels[k < 6 ? 0 : 1];
        EXPECT_LE(static_cast<double>(ball.vertices.size()),
                  level.max_support * sphere_.vertices());
        const auto row = sphere_.distances.row(ball.center);
        for (const int v : ball.vertices) EXPECT_LE(row[at(v)], level.sparsity_range);
        EXPECT_TRUE(std::ranges::binary_search(ball.vertices, ball.center));
    }
}

// Around no centre lie `most` others that came before it. One hot place would have them all.
TEST_F(BallStart, CentersDoNotPileUp) {
    MatrixXd shapes = 0.01 * cases::random_matrix(9 * sphere_.vertices(), 40, 1);
    const Ball hot = sphere_.ball(30, 0.1);
    for (const int v : hot.vertices) shapes.middleRows(9 * v, 9) *= 1000;
    const MetricRows rows = cases::rows_of(shapes);
    const auto most_together = [&](int most) {
        MultiscaleSettings settings = small_settings();
        settings.global_components = 0;
        settings.spread.most = most;
        const BallComponents components = start_balls(rows, settings, sphere_.distances);
        int worst = 0;
        for (int k = 0; k < components.count(); ++k) {
            const auto row = sphere_.distances.row(components.balls()[at(k)].center);
            int before = 0;
            for (int l = 0; l < k; ++l) {
                before += row[at(components.balls()[at(l)].center)] <= 0.15 ? 1 : 0;
            }
            worst = std::max(worst, before + 1);
        }
        return worst;
    };
    EXPECT_LE(most_together(2), 2);
    EXPECT_GT(most_together(60), 6);
}

// What the shapes are made of is found, and then nothing is left: zero, and a centre all the same.
TEST_F(BallStart, TakesOutWhatIsThere) {
    const BallComponents truth = sphere_.components(1, 0.12);
    const MatrixXd direction = cases::dense(truth);
    const MetricRows rows = cases::rows_of(direction * cases::random_matrix(1, 30, 2));
    MultiscaleSettings settings = small_settings();
    settings.global_components = 0;
    settings.levels = {{3, 0.3, 0.5}};
    const MatrixXd C = cases::dense(start_balls(rows, settings, sphere_.distances));
    EXPECT_GT(std::abs(C.col(0).dot(direction.col(0))), 1 - 1e-6);
    EXPECT_EQ(C.col(1).norm(), 0);
    EXPECT_EQ(C.col(2).norm(), 0);
    // Nor is a component made of the rounding that global ones leave.
    settings.global_components = 2;
    const BallComponents after = start_balls(rows, settings, sphere_.distances);
    const MatrixXd D = cases::dense(after);
    EXPECT_GT(std::abs(D.col(0).dot(direction.col(0))), 1 - 1e-6);
    for (int k = 1; k < D.cols(); ++k) EXPECT_EQ(D.col(k).norm(), 0) << k;
    for (const Ball& ball : after.balls()) EXPECT_FALSE(ball.vertices.empty());
}

}  // namespace
}  // namespace mscomp
