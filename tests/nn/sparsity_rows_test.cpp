// SPDX-License-Identifier: MIT
#include "mscomp/nn/sparsity_rows.h"

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
    SparsityRows sparsity(line, {1, 0.25, 1.0, {}});
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
    SparsityRows sparsity(line, {1, 0.25, 0.3, {}});
    EXPECT_EQ(free_count(sparsity.row(0)), 25);  // 25 of 101 are fewer than 30 %
    const SparsityRow middle = sparsity.row(50);
    EXPECT_EQ(free_count(middle), 29);  // 30 allowed; they come in pairs around the centre
    EXPECT_TRUE(middle.is_free(36));
    EXPECT_FALSE(middle.is_free(35));
}

// Without a limit of its own a level may act on as large a part of the vertices as its range says.
TEST(SparsityRows, TakeTheRangeAsLimitByDefault) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.25, {}, {}});
    EXPECT_EQ(free_count(sparsity.row(50)), 25);
}

// clip((d - from) / (to - from), 0, 1) of the AAAI-18 predecessor.
TEST(SparsityRows, RiseAlongTheRamp) {
    LineDistances line(101);
    SparsityRows sparsity(line, {1, 0.9, {}, SparsityRamp{0.2, 0.4}});
    const SparsityRow row = sparsity.row(0);
    EXPECT_EQ(row.weight(20), 0);
    EXPECT_NEAR(row.weight(25), 0.25, 1e-12);
    EXPECT_EQ(row.weight(40), 1);
}

}  // namespace
}  // namespace mscomp::nn
