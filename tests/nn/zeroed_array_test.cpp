// SPDX-License-Identifier: MIT
#include "nn/zeroed_array.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "nn/parameter_set.h"

namespace mscomp::nn {
namespace {

constexpr std::size_t kLarge = std::size_t{1} << 24;  // 64 MiB of float

/// Pages that hold something of [begin, end).
template <class T>
std::size_t pages_in_memory(const T* begin, const T* end) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const auto first = reinterpret_cast<std::uintptr_t>(begin) / page * page;
    const std::size_t bytes = reinterpret_cast<std::uintptr_t>(end) - first;
    std::vector<unsigned char> is_there((bytes + page - 1) / page);
    EXPECT_EQ(::mincore(reinterpret_cast<void*>(first), bytes, is_there.data()), 0);
    return static_cast<std::size_t>(
        std::ranges::count_if(is_there, [](unsigned char flags) { return (flags & 1) != 0; }));
}

bool all_zero(const ZeroedArray<float>& array) {
    return std::ranges::all_of(array, [](float x) { return x == 0; });
}

TEST(ZeroedArray, TakesUpOnlyWhatIsWritten) {
    ZeroedArray<float> array;
    array.grow(kLarge);
    EXPECT_EQ(pages_in_memory(array.begin(), array.end()), 0U);
    array.data()[5] = 1;
    array.data()[kLarge / 2] = 1;
    const std::size_t used = pages_in_memory(array.begin(), array.end());
    EXPECT_GE(used, 2U);
    // Two pages, or two huge ones where the system makes all of them huge.
    EXPECT_LE(used, 1024U);
}

TEST(ZeroedArray, KeepsWhatItHoldsWhenItGrows) {
    ZeroedArray<float> array;
    std::size_t before = 0;
    for (const std::size_t size : {3U, 1000U, 1025U, 400'000U}) {
        array.grow(size);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % 64, 0U);
        ASSERT_EQ(array.size(), size);
        for (std::size_t i = 0; i < size; ++i) {
            ASSERT_EQ(array.data()[i], i < before ? static_cast<float>(i) : 0.0F);
            array.data()[i] = static_cast<float>(i);
        }
        before = size;
    }
}

TEST(ZeroedArray, GrowingUsesNoPage) {
    ZeroedArray<float> array;
    array.grow(kLarge);
    array.grow(4 * kLarge);
    EXPECT_EQ(pages_in_memory(array.begin(), array.end()), 0U);
}

TEST(ZeroedArray, ResetGivesZerosAndTheMemoryBack) {
    ZeroedArray<float> array;
    array.grow(kLarge);
    const float* const place = array.data();
    std::ranges::fill(array, 1.0F);
    EXPECT_GE(pages_in_memory(array.begin(), array.end()), kLarge * sizeof(float) / 65536);
    array.reset();
    EXPECT_EQ(pages_in_memory(array.begin(), array.end()), 0U);
    EXPECT_EQ(array.data(), place);
    EXPECT_TRUE(all_zero(array));
}

// Of a part, however it lies to pages: exactly it becomes zero, and a large one is given back.
TEST(ZeroedArray, ResetOfAPartLeavesTheRest) {
    constexpr std::size_t kSize = 1 << 18;
    for (const std::size_t first :
         {std::size_t{0}, std::size_t{1}, std::size_t{1024}, std::size_t{70'001}}) {
        for (const std::size_t size :
             {std::size_t{0}, std::size_t{3}, std::size_t{2048}, std::size_t{16'384},
              std::size_t{17'000}, std::size_t{100'003}}) {
            ZeroedArray<float> array;
            array.grow(kSize);
            std::ranges::fill(array, 1.0F);
            array.reset(first, first + size);
            for (std::size_t i = 0; i < kSize; ++i) {
                ASSERT_EQ(array.data()[i], i >= first && i < first + size ? 0.0F : 1.0F)
                    << i << " of " << first << " + " << size;
            }
        }
    }
    ZeroedArray<float> array;
    array.grow(kLarge);
    array.reset(1, kLarge - 1);
    EXPECT_LE(pages_in_memory(array.begin(), array.end()), 1024U) << "zeros need no memory";
}

TEST(ZeroedArray, MovesLeaveNothingBehind) {
    ZeroedArray<float> array;
    array.grow(10);
    array.data()[9] = 7;
    ZeroedArray<float> moved = std::move(array);
    EXPECT_EQ(moved.data()[9], 7);
    ZeroedArray<float> assigned;
    assigned = std::move(moved);
    EXPECT_EQ(assigned.size(), 10U);
    EXPECT_EQ(assigned.data()[9], 7);
    EXPECT_EQ(array.size(), 0U);  // NOLINT(bugprone-use-after-move)
    EXPECT_EQ(array.begin(), array.end());
    EXPECT_EQ(moved.size(), 0U);  // NOLINT(bugprone-use-after-move)
}

// A parameter that nobody writes to costs nothing, in any of the four allocations.
TEST(ParameterSet, UntouchedParametersTakeUpNoMemory) {
    ParameterSet<float> parameters;
    const int small = parameters.add("small", {9});
    const int large = parameters.add("large", {static_cast<std::int64_t>(kLarge)});
    parameters.add("last", {9});
    for (const auto& all : {parameters.all_values(), parameters.all_grads(),
                            parameters.all_moments1(), parameters.all_moments2()}) {
        EXPECT_EQ(pages_in_memory(all.data(), all.data() + all.size()), 0U);
    }
    parameters.value(small)[0] = 1;
    EXPECT_LE(
        pages_in_memory(parameters.value(large).data(), parameters.value(large).data() + kLarge),
        512U);
}

// What stops being live is zero, and costs nothing where it never was anything else.
TEST(ParameterSet, WhatIsNotLiveTakesUpNoMemory) {
    ParameterSet<float> parameters;
    const int index = parameters.add("large", {static_cast<std::int64_t>(kLarge)});
    parameters.moment1(index)[5] = parameters.moment1(index)[kLarge / 2] = 1;
    parameters.set_live(index, {{0, 10}});
    EXPECT_EQ(parameters.moment1(index)[5], 1);
    EXPECT_EQ(parameters.moment1(index)[kLarge / 2], 0);
    for (const auto& all :
         {parameters.all_grads(), parameters.all_moments1(), parameters.all_moments2()}) {
        EXPECT_LE(pages_in_memory(all.data(), all.data() + all.size()), 512U);
    }
}

TEST(ParameterSet, KeepsValuesWhenOneIsAdded) {
    ParameterSet<double> parameters;
    const int first = parameters.add("first", {3});
    parameters.value(first)[2] = 5;
    parameters.moment2(first)[1] = 6;
    const int second = parameters.add("second", {100'000});
    EXPECT_EQ(parameters.value(first)[2], 5);
    EXPECT_EQ(parameters.moment2(first)[1], 6);
    EXPECT_EQ(parameters.value(second)[99'999], 0);
}

TEST(ParameterSet, ResetOfTheValuesLeavesTheRest) {
    ParameterSet<float> parameters;
    const int index = parameters.add("p", {5000});
    std::ranges::fill(parameters.all_values(), 2.0F);
    std::ranges::fill(parameters.all_grads(), 3.0F);
    parameters.reset_values();
    EXPECT_EQ(parameters.value(index)[4999], 0);
    EXPECT_EQ(parameters.grad(index)[4999], 3);
}

}  // namespace
}  // namespace mscomp::nn
