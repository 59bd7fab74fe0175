// SPDX-License-Identifier: MIT
#include "mscomp/base/parallel.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace mscomp {
namespace {

class ParallelFor : public testing::TestWithParam<int> {
  protected:
    void SetUp() override { set_thread_count(GetParam()); }
    void TearDown() override { set_thread_count(0); }
};

TEST_P(ParallelFor, CallsEveryIndexOnce) {
    std::vector<int> calls(1000, 0);
    parallel_for(1000, [&](std::int64_t i) { ++calls[static_cast<std::size_t>(i)]; });
    for (const int count : calls) EXPECT_EQ(count, 1);
}

TEST_P(ParallelFor, ThrowsWhatTheSmallestFailingIndexThrew) {
    try {
        parallel_for(100, [](std::int64_t i) {
            if (i % 30 == 20) throw std::runtime_error(std::to_string(i));
        });
        FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "20");
    }
}

TEST_P(ParallelFor, NestedCallsCoverEverything) {
    std::vector<int> calls(64, 0);
    parallel_for(8, [&](std::int64_t i) {
        parallel_for(8, [&](std::int64_t j) { ++calls[static_cast<std::size_t>(8 * i + j)]; });
    });
    for (const int count : calls) EXPECT_EQ(count, 1);
}

INSTANTIATE_TEST_SUITE_P(Threads, ParallelFor, testing::Values(1, 2, 7));

TEST(Chunks, CutARangeWithoutGapOrOverlap) {
    const Chunks chunks{10, 4};
    ASSERT_EQ(chunks.count(), 3);
    EXPECT_EQ(chunks.begin(0), 0);
    for (int c = 0; c + 1 < 3; ++c) EXPECT_EQ(chunks.end(c), chunks.begin(c + 1));
    EXPECT_EQ(chunks.end(2), 10);
}

}  // namespace
}  // namespace mscomp
