// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace mscomp {

/// Random numbers that are a function of (seed, stream, index) and of nothing else, so that a
/// resumed run draws what an uninterrupted one would have drawn. Philox 4x32-10 (Salmon et al.
/// 2011).
class CounterRandom {
  public:
    CounterRandom(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}

    /// 64 independent bits.
    std::uint64_t bits(std::uint64_t index) const;
    /// Uniform in [0, 1).
    double uniform(std::uint64_t index) const;
    /// Standard normal (Box-Muller on the two halves of one block).
    double normal(std::uint64_t index) const;
    /// A uniformly drawn permutation of 0..count-1 (Fisher-Yates).
    std::vector<int> permutation(int count) const;

  private:
    std::uint64_t seed_;
    std::uint64_t stream_;
};

}  // namespace mscomp
