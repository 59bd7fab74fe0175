// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "mscomp/base/index.h"

namespace mscomp {

/// Steps in the order of their costs in [0, 1], in constant time each: costs that differ by less
/// than one part in eight count as equal (last in, first out).
class StepQueue {
  public:
    StepQueue() { head_.fill(-1); }

    bool empty() const { return count_ == 0; }

    void push(double cost, int step) {
        const std::size_t bucket = bucket_of(cost);
        entries_.push_back({step, head_[bucket]});
        head_[bucket] = static_cast<int>(entries_.size()) - 1;
        filled_[bucket / 64] |= std::uint64_t{1} << (bucket % 64);
        ++count_;
    }

    int pop() {
        std::size_t word = 0;
        while (filled_[word] == 0) ++word;
        const auto bucket = 64 * word + at(std::countr_zero(filled_[word]));
        const Entry entry = entries_[at(head_[bucket])];
        head_[bucket] = entry.below;
        if (entry.below < 0) filled_[word] &= filled_[word] - 1;
        --count_;
        return entry.step;
    }

  private:
    // Positive floats sort like their bits: exponent and three bits of the mantissa, up to 1.
    static constexpr std::size_t kBuckets = (std::bit_cast<std::uint32_t>(1.0F) >> 20) + 1;
    static std::size_t bucket_of(double cost) {
        const auto clamped = static_cast<float>(std::clamp(cost, 0.0, 1.0));
        return std::min<std::size_t>(std::bit_cast<std::uint32_t>(clamped) >> 20, kBuckets - 1);
    }

    struct Entry {
        int step, below;
    };
    std::vector<Entry> entries_;
    std::array<int, kBuckets> head_;
    std::array<std::uint64_t, kBuckets / 64 + 1> filled_{};
    std::int64_t count_ = 0;
};

}  // namespace mscomp
