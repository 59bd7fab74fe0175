// SPDX-License-Identifier: MIT
#include "mscomp/eval/unit_matches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

// Four shapes. Centred: code 0 is (-3, -1, 1, 3) / 2, code 1 is (-1, 1, -1, 1) / 2 about its mean;
// the units are (0, 1, 2, 3) -> (-3, -1, 1, 3) / 2 and (0, 0, 0, 1) -> (-1, -1, -1, 3) / 4.
//   code 0, unit 0: the same                          -> 1
//   code 0, unit 1: (3 + 1 - 1 + 9) / 8 = 12/8, over sqrt(20/4 * 12/16)
//   code 1, unit 0: (3 - 1 - 1 + 3) / 4 = 1,    over sqrt(1 * 20/4)
//   code 1, unit 1: (1 - 1 + 1 + 3) / 8 = 1/2,  over sqrt(1 * 12/16)
const std::vector<double> kCodes{0, 5, 1, 6, 2, 5, 3, 6};
const std::vector<double> kWeights{0, 0, 1, 0, 2, 0, 3, 1};

TEST(CorrelationTable, AgreesWithAnExampleByHand) {
    const UnitMatches matches = correlation_table(kCodes, kWeights, 4);
    ASSERT_EQ(matches.code_count, 2);
    ASSERT_EQ(matches.unit_count, 2);
    EXPECT_NEAR(matches.at(0, 0), 1, 1e-14);
    EXPECT_NEAR(matches.at(0, 1), 1.5 / std::sqrt(5 * 0.75), 1e-14);
    EXPECT_NEAR(matches.at(1, 0), 1 / std::sqrt(5.0), 1e-14);
    EXPECT_NEAR(matches.at(1, 1), 0.5 / std::sqrt(0.75), 1e-14);
    // Unit 1 is best told by code 0, too (0.775 beside 0.577); one to one it is left with code 1.
    EXPECT_EQ(matches.best[0].code, 0);
    EXPECT_EQ(matches.best[1].code, 0);
    EXPECT_EQ(matches.matched, 1);
    EXPECT_EQ(matches.one_to_one[0].code, 0);
    EXPECT_EQ(matches.one_to_one[1].code, 1);
    EXPECT_EQ(matches.one_to_one[1].correlation, matches.at(1, 1));
    EXPECT_EQ(matches.matched_one_to_one, 1);
    EXPECT_EQ(correlation_table(kCodes, kWeights, 4, 0.7).matched, 2);
    EXPECT_EQ(correlation_table(kCodes, kWeights, 4, 0.7).matched_one_to_one, 1);
}

// A sign, a scale and an offset of a code change nothing.
TEST(CorrelationTable, DoesNotSeeSignScaleOrOffset) {
    std::vector<double> codes = kCodes;
    for (std::size_t i = 0; i < codes.size(); i += 2) codes[i] = 7 - 1e3 * codes[i];
    const UnitMatches before = correlation_table(kCodes, kWeights, 4);
    const UnitMatches after = correlation_table(codes, kWeights, 4);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(after.correlation[i], before.correlation[i], 1e-12);
    }
}

TEST(CorrelationTable, OfConstantOrBrokenColumnsIsZero) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> codes, weights;
    for (int shape = 0; shape < 10; ++shape) {
        // The mean of ten times 0.1 is not 0.1: rounding must not make it vary.
        codes.insert(codes.end(), {0.1, shape == 3 ? nan : shape});
        weights.push_back(shape);
    }
    const UnitMatches matches = correlation_table(codes, weights, 10);
    EXPECT_EQ(matches.at(0, 0), 0);
    EXPECT_EQ(matches.at(1, 0), 0);
    EXPECT_EQ(matches.matched, 0);
    EXPECT_EQ(correlation_table(codes, codes, 10).at(0, 0), 0);
    EXPECT_EQ(correlation_table({}, std::vector<double>{0, 1, 2}, 3).best[0].code, -1);
}

// Independent noise of many shapes does not correlate; the weights themselves, shuffled, do.
TEST(CorrelationTable, FindsThePermutation) {
    const CounterRandom random(1, 2);
    constexpr std::size_t kShapes = 400, kUnits = 5;
    const std::vector<int> order = random.permutation(kUnits);
    std::vector<double> weights, codes(kShapes * kUnits);
    for (std::size_t i = 0; i < kShapes * kUnits; ++i) weights.push_back(random.uniform(1000 + i));
    for (std::size_t i = 0; i < codes.size(); ++i) {
        const std::size_t shape = i / kUnits;
        codes[i] = -weights[shape * kUnits + static_cast<std::size_t>(order[i % kUnits])];
    }
    const UnitMatches matches = correlation_table(codes, weights, kShapes);
    EXPECT_EQ(matches.matched, 5);
    EXPECT_EQ(matches.matched_one_to_one, 5);
    for (std::size_t u = 0; u < kUnits; ++u) {
        EXPECT_EQ(order[static_cast<std::size_t>(matches.best[u].code)], static_cast<int>(u));
        EXPECT_EQ(matches.best[u].code, matches.one_to_one[u].code);
        for (int k = 0; k < 5; ++k) {
            if (k != matches.best[u].code) {
                EXPECT_LT(matches.at(k, static_cast<int>(u)), 0.25);
            }
        }
    }
}

// More units than codes: some are left without one, each code serves once.
TEST(CorrelationTable, LeavesUnitsWithoutACode) {
    const UnitMatches matches =
        correlation_table(std::vector<double>{0, 1, 5}, std::vector<double>{0, 0, 1, 1, 5, 4}, 3);
    EXPECT_EQ(matches.best[1].code, 0);
    EXPECT_EQ(matches.one_to_one[0].code, 0);
    EXPECT_EQ(matches.one_to_one[1].code, -1);
    EXPECT_EQ(matches.one_to_one[1].correlation, 0);
    EXPECT_EQ(matches.matched, 2);
    EXPECT_EQ(matches.matched_one_to_one, 1);
}

TEST(CorrelationTable, RefusesWhatDoesNotFit) {
    EXPECT_THROW(correlation_table(kCodes, kWeights, 3), UsageError);
    EXPECT_THROW(correlation_table(kCodes, kWeights, 0), UsageError);
    EXPECT_THROW(correlation_table(kCodes, std::vector<double>{1, 2}, 4), UsageError);
}

}  // namespace
}  // namespace mscomp
