// SPDX-License-Identifier: MIT
#include "nn/sparsity_rows.h"

#include <gtest/gtest.h>

#include "op_table.h"

namespace mscomp::nn {
namespace {

int free_count(const SparsityRow& row) {
    int count = 0;
    for (int v = 0; v < static_cast<int>(row.distances.size()); ++v)
        count += row.is_free(v) ? 1 : 0;
    return count;
}

// [A] eq. 3: 0 where d < range, 1 where d >= range; the line has 101 vertices at distance 1/100.
TEST(SparsityRows, AreAStepAtTheRange) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.25, 1.0, {}}, CenterRule::settle);
    const SparsityRow row = sparsity.row(0);
    EXPECT_EQ(row.weight(24), 0);
    EXPECT_EQ(row.weight(25), 1);
    EXPECT_EQ(free_count(sparsity.row(0)), 25);
    EXPECT_EQ(free_count(sparsity.row(50)), 49);
}

// Where the range holds too many vertices it shrinks: at most that part of them is free, the
// nearest.
TEST(SparsityRows, ShrinkToTheLargestSupport) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.25, 0.3, {}}, CenterRule::settle);
    EXPECT_EQ(free_count(sparsity.row(0)), 25);  // 25 of 101 are fewer than 30 %
    const SparsityRow middle = sparsity.row(50);
    EXPECT_EQ(free_count(middle), 29);  // 30 allowed; they come in pairs around the centre
    EXPECT_TRUE(middle.is_free(36));
    EXPECT_FALSE(middle.is_free(35));
}

// Without a limit of its own a level is free on nine tenths of the part that its range names: the
// ring that the convolution adds has to fit in.
TEST(SparsityRows, TakeTheRangeAsLimitByDefault) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.25, {}, {}}, CenterRule::settle);
    EXPECT_EQ(free_count(sparsity.row(50)), 25);  // the centre and pairs around it
}

// A limit of less than one vertex leaves the centre.
TEST(SparsityRows, LeaveAtLeastTheCentreFree) {
    LineDistances line(5);
    SparsityRows sparsity(line, {1, 0.9, 0.1, {}}, CenterRule::settle);
    for (int center = 0; center < 5; ++center) {
        EXPECT_TRUE(sparsity.row(center).is_free(center));
        EXPECT_EQ(free_count(sparsity.row(center)), 1);
    }
}

// clip((d - from) / (to - from), 0, 1) of the AAAI-18 predecessor.
TEST(SparsityRows, RiseAlongTheRamp) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.9, {}, SparsityRamp{0.2, 0.4}}, CenterRule::settle);
    const SparsityRow row = sparsity.row(0);
    EXPECT_EQ(row.weight(20), 0);
    EXPECT_NEAR(row.weight(25), 0.25, 1e-12);
    EXPECT_EQ(row.weight(40), 1);
}

/// Two components of 101 vertices along the line; entry v of channel 0 from a function.
template <class Length>
std::vector<double> component(Length length) {
    std::vector<double> c(101 * 9, 0.0);
    for (int v = 0; v < 101; ++v) c[static_cast<std::size_t>(v * 9)] = length(v);
    return c;
}

// A centre that follows sits on the longest vertex, lowest index on ties.
TEST(SparsityRows, CentersThatFollowSitOnTheLongestVertex) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.25, 1.0, {}}, CenterRule::follow);
    const auto first = component([](int v) { return v == 30 || v == 70 ? 2.0 : 1.0; });
    sparsity.focus(std::span<const double>(first));
    EXPECT_EQ(sparsity.centers(), std::vector<int>{30});
    const auto second = component([](int v) { return v == 70 ? 2.0 : 1.0; });
    sparsity.focus(std::span<const double>(second));
    EXPECT_EQ(sparsity.centers(), std::vector<int>{70});
}

// A settled centre stays where its component lives when another vertex becomes the longest, and
// moves when that lowers the penalty.
TEST(SparsityRows, CentersThatSettleMoveOnlyToLowerThePenalty) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.25, 1.0, {}}, CenterRule::settle);
    sparsity.set_centers({30});
    const auto at_home =
        component([](int v) { return v > 5 && v < 55 ? (v == 50 ? 2.0 : 1.0) : 0; });
    sparsity.focus(std::span<const double>(at_home));
    EXPECT_EQ(sparsity.centers(), std::vector<int>{30});
    const auto moved =
        component([](int v) { return v > 30 && v < 70 ? (v == 50 ? 2.0 : 1.0) : 0; });
    sparsity.focus(std::span<const double>(moved));
    EXPECT_EQ(sparsity.centers(), std::vector<int>{50});
}

}  // namespace
}  // namespace mscomp::nn
