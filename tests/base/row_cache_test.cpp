// SPDX-License-Identifier: MIT
#include "mscomp/base/row_cache.h"

#include <gtest/gtest.h>

namespace mscomp {
namespace {

std::vector<double> row_of(double value) { return {value, value, value, value}; }
constexpr std::size_t kRowBytes = 4 * sizeof(double);

TEST(RowCache, GivesBackWhatWasPut) {
    RowCache cache(10 * kRowBytes);
    EXPECT_FALSE(cache.find(3));
    const auto put = cache.put(3, row_of(1.5));
    const auto found = cache.find(3);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->data(), put.data());
    EXPECT_EQ((*found)[2], 1.5);
    EXPECT_EQ(cache.bytes(), kRowBytes);
}

// The limit holds as soon as rows may go: those used longest ago first.
TEST(RowCache, DropsWhatWasUsedLongestAgo) {
    RowCache cache(3 * kRowBytes);
    for (int key = 0; key < 3; ++key) cache.put(key, row_of(key));
    cache.start_round();
    cache.find(0);
    cache.start_round();
    cache.put(7, row_of(7));
    EXPECT_EQ(cache.bytes(), 3 * kRowBytes);
    EXPECT_TRUE(cache.find(0)) << "used since";
    EXPECT_FALSE(cache.find(1)) << "the oldest";
    EXPECT_TRUE(cache.find(2));
    EXPECT_TRUE(cache.find(7));
}

// What was found or put in this round stays, even beyond the limit.
TEST(RowCache, KeepsTheRoundWhateverTheLimit) {
    RowCache cache(0);
    const double* first = cache.put(0, row_of(0)).data();
    for (int key = 1; key < 100; ++key) cache.put(key, row_of(key));
    EXPECT_EQ(cache.row_count(), 100U);
    EXPECT_EQ(cache.find(0)->data(), first);
    cache.start_round();
    EXPECT_EQ(cache.find(0)->data(), first);
    cache.put(200, row_of(200));
    EXPECT_EQ(cache.row_count(), 2U) << "0 was found in this round, 200 put";
    EXPECT_TRUE(cache.find(0));
}

}  // namespace
}  // namespace mscomp
