// SPDX-License-Identifier: MIT
#include "units/weighted_squares.h"

#include <gtest/gtest.h>

#include "multiscale/ball_cases.h"
#include "units/quiet_codes.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr int kLanes = WeightedSquares::kLanes;

// Σ_i ω_i Y_iᵀ Y_i, by the definition, of places of one row and of three, for numbers of directions
// whose triangle fills its groups and does not.
TEST(WeightedSquares, AreThoseOfTheDefinitionInEveryLane) {
    for (const int width : {1, 3}) {
        for (const int directions : {1, 2, 4, 5}) {
            constexpr int kPlaces = 7;
            const MatrixXd places = cases::random_matrix(kPlaces * width, directions, 3);
            const Eigen::Matrix<double, kPlaces, kLanes, Eigen::RowMajor> weights =
                cases::random_matrix(kPlaces, kLanes, 4).cwiseAbs();
            const WeightedSquares squares(places, width);
            ASSERT_EQ(squares.directions(), directions);
            std::vector<double> sums(squares.sums_size());
            squares.add_up(weights.data(), sums.data());
            for (int lane = 0; lane < kLanes; ++lane) {
                const VectorXd of_rows =
                    weights.col(lane).replicate(1, width).transpose().reshaped();
                const MatrixXd wanted = places.transpose() * of_rows.asDiagonal() * places;
                MatrixXd found = MatrixXd::Zero(directions, directions);
                squares.lower(sums.data(), lane, found);
                found = found.selfadjointView<Eigen::Lower>();
                EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), 1e-12) << width << ", " << lane;
            }
        }
    }
}

// What stands beside a read-out does not change it.
TEST(QuietReadouts, AreTheSameAloneAndInACrowd) {
    const MatrixXd places = cases::random_matrix(3 * 40, 6, 3),
                   here = cases::random_matrix(6, 70, 4);
    const QuietSearch search{places, 3, VectorXd::Constant(6, 0.1), 2, 1};
    const std::vector<QuietReadout> all = quiet_readouts(search, here);
    ASSERT_EQ(all.size(), 70U);
    for (const Index i : {0, 31, 32, 69}) {
        const QuietReadout alone = quiet_readouts(search, here.col(i)).front();
        EXPECT_LT((alone.weights - all[at(i)].weights).cwiseAbs().maxCoeff(), 1e-9) << i;
        EXPECT_NEAR(here.col(i).dot(all[at(i)].weights), 1, 1e-12);
        EXPECT_NEAR(all[at(i)].sizes.maxCoeff(), 1, 1e-12);
    }
}

}  // namespace
}  // namespace mscomp
