// SPDX-License-Identifier: MIT
#include "mscomp/model/given_components.h"

#include <gtest/gtest.h>

#include <cmath>

#include "two_components.h"

namespace mscomp::nn {
namespace {

// Two shapes with codes (-0.5, 0) and (2, 0): mean 0.75 and deviation 1.25 of the first, the second
// deviates by 1 for want of anything else. Features are tanh(sum C_k z_k), unscaled by 0.5.
TEST(GivenComponents, AreTheSecantOverTheCodesThatShapesHave) {
    const TwoComponents hand;
    const GivenComponents given = given_components(*hand.network, hand.codes);
    ASSERT_EQ(given.count(), 2);
    EXPECT_EQ(given.levels.size(), 1U);
    EXPECT_EQ(given.parents, (std::vector<int>{-1, -1}));
    EXPECT_EQ(given.centers, (std::vector<int>{1, 0}));
    const CodeColumn& first = given.changes[0];
    ASSERT_EQ(first.vertices, (std::vector<int>{0, 2, 3}));
    const auto secant = [](double weight) {
        return (std::tanh(2 * weight) - std::tanh(-0.5 * weight)) / (0.5 * 2.5);
    };
    EXPECT_NEAR(first.values[0], secant(0.5), 1e-6);
    EXPECT_NEAR(first.values[9 + 4], secant(1), 1e-6);
    EXPECT_NEAR(first.values[18], secant(0.004), 1e-6);
    // At the mean of the other code.
    const CodeColumn& second = given.changes[1];
    ASSERT_EQ(second.vertices, (std::vector<int>{0}));
    EXPECT_NEAR(second.values[0],
                (std::tanh(0.5 * 0.75 + 0.25) - std::tanh(0.5 * 0.75 - 0.25)) / (0.5 * 2), 1e-6);
}

}  // namespace
}  // namespace mscomp::nn
