// SPDX-License-Identifier: MIT
#include "units/unit_components.h"

#include <gtest/gtest.h>

#include "mscomp/base/parallel.h"
#include "multiscale/ball_cases.h"
#include "units/planted_units.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

/// Components on balls, and shapes in which they switch on and off.
struct PlantedBalls {
    cases::Sphere sphere;
    BallComponents components;
    MatrixXd codes;
    MetricRows rows;

    explicit PlantedBalls(std::vector<double> radii, int width = kFeatureDim)
        : components(balls(radii, width)),
          codes(cases::switching_codes(50, static_cast<int>(radii.size()))),
          rows(cases::rows_of(cases::dense(components) * codes.transpose(), width)) {}

    BallComponents balls(const std::vector<double>& radii, int width) {
        std::vector<Ball> all;
        for (std::size_t k = 0; k < radii.size(); ++k) {
            all.push_back(sphere.ball(static_cast<int>(29 * k) % sphere.vertices(), radii[k]));
        }
        BallComponents result(sphere.vertices(), std::move(all), width);
        const CounterRandom random(5, 0);
        for (std::size_t i = 0; i < result.all_values().size(); ++i) {
            result.all_values()[i] = static_cast<float>(1 + 0.2 * random.normal(i));
        }
        return result;
    }
};

class UnitComponentsOf : public testing::TestWithParam<int> {};

TEST_P(UnitComponentsOf, AreThoseThatWerePlantedWithExactZerosElsewhere) {
    const PlantedBalls planted({0.2, 0.3, 0.25}, GetParam());
    const BallComponents found = unit_components(planted.rows, planted.codes);
    for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(found.balls()[at(k)].vertices, planted.components.balls()[at(k)].vertices) << k;
        const std::vector<float> values = found.component(k);
        const std::vector<float> wanted = planted.components.component(k);
        ASSERT_EQ(values.size(), wanted.size());
        for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(values[i], wanted[i], 1e-4);
    }
    EXPECT_LT(squares_left(planted.rows, found), 1e-8);
    const BallComponents one = unit_components(planted.rows, planted.codes.leftCols(1));
    const MatrixXd left = cases::dense(planted.components) * planted.codes.transpose();
    EXPECT_GT(squares_left(planted.rows, one), 0.1 * left.squaredNorm() / 50);
    EXPECT_LT(squares_left(planted.rows, one), left.squaredNorm() / 50);
}
INSTANTIATE_TEST_SUITE_P(Widths, UnitComponentsOf, testing::Values(9, 3));

UnitOrder order_of(const PlantedBalls& planted) {
    std::vector<int> supports;
    for (const Ball& ball : planted.components.balls()) {
        supports.push_back(static_cast<int>(ball.vertices.size()));
    }
    return order_of_units(movements(planted.components, planted.codes), supports);
}

TEST(UnitComponents, LevelsAreTheTwoScalesThatThereAre) {
    const PlantedBalls two({0.15, 0.5, 0.15, 0.5, 0.15});
    const UnitOrder order = order_of(two);
    EXPECT_EQ(order.levels, (std::vector<int>{2, 3}));
    for (const int k : {order.units[0], order.units[1]}) EXPECT_EQ(k % 2, 1);
    const PlantedBalls one({0.3, 0.3, 0.3, 0.3, 0.3});
    EXPECT_EQ(order_of(one).levels, (std::vector<int>{5}));
}

TEST(UnitComponents, ThoseThatMoveMostComeFirst) {
    PlantedBalls planted({0.3, 0.3, 0.3, 0.3});
    planted.codes.col(2) *= 3;
    EXPECT_EQ(most_moving_first(movements(planted.components, planted.codes)).front(), 2);
}

TEST(UnitComponents, InnerProductsAreThoseOfAllNumbersForAnyNumberOfThreads) {
    const MatrixXd all = cases::random_matrix(9 * 1500, 20, 3);  // several chunks
    const MetricRows rows = cases::rows_of(all);
    const MatrixXd gram = gram_of_shapes(rows);
    EXPECT_LT((gram - all.transpose() * all).norm(), 1e-5 * gram.norm());  // rows are float
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_TRUE(gram_of_shapes(rows) == gram);
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace mscomp
