// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "multiscale/ball_cases.h"
#include "units/found_units.h"
#include "units/planted_units.h"
#include "units/quiet_codes.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

struct Planted {
    MatrixXd codes, shapes;

    explicit Planted(int count = 60, int units = 6)
        : codes(cases::switching_codes(count, units)),
          shapes(codes * cases::random_matrix(units, 200, 7)) {}
    MatrixXd gram() const { return shapes * shapes.transpose(); }
};

// Shapes that are sums of units which are off most of the time: these and no others are found.
TEST(CodeRoute, FindsPlantedUnits) {
    const Planted planted;
    const FoundUnits found = find_switching_units(planted.gram());
    EXPECT_EQ(found.units.count(), 6);
    EXPECT_GT(cases::nearest_cosines(planted.codes, found.units.codes).minCoeff(), 1 - 5e-4);
    EXPECT_LT(found.unexplained, 1e-6);
    EXPECT_EQ(found.found_again(), 6);
    for (const int votes : found.units.votes) EXPECT_GE(votes, 2);
    EXPECT_GE(found.units.codes.minCoeff(), 0);
    EXPECT_NEAR(found.units.codes.maxCoeff(), 1, 1e-12);
}

// With noise they still are, and what is not explained is the noise.
TEST(CodeRoute, FindsThemUnderNoise) {
    const Planted planted;
    const MatrixXd noisy = planted.shapes + 0.05 * cases::random_matrix(60, 200, 8);
    const FoundUnits found = find_switching_units(noisy * noisy.transpose());
    EXPECT_EQ(found.units.count(), 6);
    EXPECT_GT(cases::nearest_cosines(planted.codes, found.units.codes).minCoeff(), 0.99);
}

// Nothing hangs on the order of the shapes, on their unit, or on how space is turned.
TEST(CodeRoute, TheOrderOfShapesAndTheirUnitDoNotMatter) {
    const Planted planted;
    const FoundUnits wanted = find_switching_units(planted.gram());
    const std::vector<int> order = CounterRandom(5, 5).permutation(60);
    MatrixXd mixed(60, 200), codes(60, 6);
    for (int n = 0; n < 60; ++n) {
        mixed.row(n) = planted.shapes.row(order[at(n)]);
        codes.row(n) = wanted.units.codes.row(order[at(n)]);
    }
    for (const double unit : {1.0, 1e-3, 1e4}) {
        const FoundUnits found = find_switching_units(unit * unit * (mixed * mixed.transpose()));
        EXPECT_EQ(found.units.count(), 6) << unit;
        EXPECT_GT(cases::nearest_cosines(codes, found.units.codes).minCoeff(), 1 - 5e-4) << unit;
    }
}

// Also where codes explain too little to be fitted, so that those of one read-out are the result.
TEST(CodeRoute, NorDoesTheOrderMatterWhereLittleIsExplained) {
    const Planted planted;
    const MatrixXd shapes = planted.shapes + 6 * cases::random_matrix(60, 200, 8);
    const std::vector<int> order = CounterRandom(5, 5).permutation(60);
    MatrixXd mixed(60, 200);
    for (int n = 0; n < 60; ++n) mixed.row(n) = shapes.row(order[at(n)]);
    const FoundUnits wanted = find_switching_units(shapes * shapes.transpose());
    const FoundUnits found = find_switching_units(mixed * mixed.transpose());
    EXPECT_GT(wanted.unexplained, 0.2);
    ASSERT_EQ(found.units.votes, wanted.units.votes);
    EXPECT_EQ(found.again, wanted.again);
    EXPECT_EQ(found.noise, wanted.noise);
    for (int n = 0; n < 60; ++n) {
        for (int k = 0; k < found.units.count(); ++k) {
            EXPECT_NEAR(found.units.codes(n, k), wanted.units.codes(order[at(n)], k), 1e-6);
        }
    }
}

// A shape that is the reference says nothing, and does not disturb.
TEST(CodeRoute, ShapesThatAreTheReferenceCountForNothing) {
    Planted planted;
    planted.codes.topRows(5).setZero();
    planted.shapes.topRows(5).setZero();
    const FoundUnits found = find_switching_units(planted.gram());
    EXPECT_EQ(found.units.count(), 6);
    EXPECT_GT(cases::nearest_cosines(planted.codes, found.units.codes).minCoeff(), 1 - 5e-4);
    EXPECT_TRUE(found.units.codes.allFinite());
}

// Shapes of which each moves in a way of its own: nothing two of them agree on.
TEST(CodeRoute, FindsNothingWhereNoTwoShapesAgree) {
    const FoundUnits found = find_switching_units(MatrixXd::Identity(12, 12));
    EXPECT_EQ(found.units.count(), 0);
    EXPECT_EQ(find_switching_units(MatrixXd::Zero(12, 12)).units.count(), 0);
}

// What is no read-out at all agrees with nothing.
TEST(Agreed, NothingAndNoNumberAreNoUnit) {
    MatrixXd candidates = MatrixXd::Zero(5, 4);
    EXPECT_EQ(agreed(candidates).count(), 0);
    candidates.rightCols(2) = Eigen::VectorXd::LinSpaced(5, 0, 1).replicate(1, 2);
    candidates.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
    const UnitCodes found = agreed(candidates);
    EXPECT_EQ(found.votes, std::vector<int>{2});
}

TEST(QuietCodes, AreOneAtTheirShapeAndNearlyZeroWhereItsUnitIsOff) {
    const Planted planted(60, 3);
    const ShapeBasis basis = shape_basis(planted.gram(), 50);
    EXPECT_EQ(basis.sizes.size(), 3) << "no more directions than there are";
    EXPECT_NEAR(basis.size, planted.shapes.norm(), 1e-9 * basis.size);
    const MatrixXd codes = quiet_codes(basis, 0.003);
    int of_units = 0;
    for (Eigen::Index m = 0; m < codes.cols(); ++m) {
        EXPECT_NEAR(codes.col(m).cwiseAbs().maxCoeff(), 1, 1e-12);
        for (Eigen::Index k = 0; k < 3; ++k) {
            const double cosine = codes.col(m).normalized().dot(planted.codes.col(k).normalized());
            if (cosine < 0.95) continue;
            ++of_units;
            for (Eigen::Index n = 0; n < codes.rows(); ++n) {
                if (planted.codes(n, k) > 0) continue;
                EXPECT_LT(std::abs(codes(n, m)), 0.05);
            }
        }
    }
    EXPECT_GT(of_units, 20);
}

// All three are each other's neighbours: the one in the middle stands for them, in any order.
TEST(UnitCodes, TheNearestOfEqualsStandsForThem) {
    MatrixXd fan(2, 3);
    for (int i = 0; i < 3; ++i) fan.col(i) << std::cos(0.1 * i), std::sin(0.1 * i);
    for (const auto& order : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}) {
        MatrixXd candidates(2, 3);
        for (int i = 0; i < 3; ++i) candidates.col(i) = fan.col(order[at(i)]);
        const UnitCodes units = agreed(candidates);
        ASSERT_EQ(units.votes, (std::vector<int>{3}));
        EXPECT_TRUE(units.codes.col(0) == fan.col(1)) << order[0];
    }
}

TEST(UnitCodes, WhatTheOthersPredictIsLeftOut) {
    UnitCodes units{cases::switching_codes(40, 4), {9, 5, 4, 3}};
    units.codes.col(2) = 0.5 * (units.codes.col(0) + units.codes.col(3));
    const UnitCodes kept = without_predicted(units);
    // The three are dependent: that with the fewest votes goes.
    EXPECT_EQ(kept.votes, (std::vector<int>{9, 5, 4}));
}

TEST(UnitCodes, AnUnitServesOneOnly) {
    const UnitCodes all{cases::switching_codes(40, 3), {2, 2, 2}};
    UnitCodes part{MatrixXd(40, 2), {2, 2}};
    part.codes.col(0) = 3 * all.codes.col(1);
    part.codes.col(1) = all.codes.col(1);
    std::vector<int> which(40);
    std::iota(which.begin(), which.end(), 0);
    EXPECT_EQ(found_again(all, part, which), (std::vector<bool>{false, true, false}));
}

}  // namespace
}  // namespace mscomp
