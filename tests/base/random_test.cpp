// SPDX-License-Identifier: MIT
#include "mscomp/base/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mscomp {
namespace {

// Known answer published with the generator (philox4x32, 10 rounds, counter and key zero).
TEST(CounterRandom, MatchesThePublishedVector) {
    EXPECT_EQ(CounterRandom(0, 0).bits(0), 0xe169c58d6627e8d5u);
}

TEST(CounterRandom, IsAFunctionOfSeedStreamAndIndex) {
    EXPECT_EQ(CounterRandom(3, 4).bits(5), CounterRandom(3, 4).bits(5));
    EXPECT_NE(CounterRandom(3, 4).bits(5), CounterRandom(3, 4).bits(6));
    EXPECT_NE(CounterRandom(3, 4).bits(5), CounterRandom(3, 5).bits(5));
    EXPECT_NE(CounterRandom(3, 4).bits(5), CounterRandom(4, 4).bits(5));
}

// The sample mean of n standard normals lies within 5/sqrt(n) of 0, the variance within 5 sqrt(2/n)
// of 1.
TEST(CounterRandom, NormalHasMeanZeroAndVarianceOne) {
    const CounterRandom random(1, 0);
    const int count = 20000;
    double sum = 0, squares = 0;
    for (int i = 0; i < count; ++i) {
        const double x = random.normal(static_cast<std::uint64_t>(i));
        sum += x;
        squares += x * x;
    }
    EXPECT_LT(std::abs(sum / count), 5 / std::sqrt(count));
    EXPECT_LT(std::abs(squares / count - 1), 5 * std::sqrt(2.0 / count));
}

TEST(CounterRandom, PermutationHoldsEveryIndexOnce) {
    std::vector<int> order = CounterRandom(7, 1).permutation(100);
    EXPECT_FALSE(std::is_sorted(order.begin(), order.end()));
    std::sort(order.begin(), order.end());
    for (int i = 0; i < 100; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace mscomp
