// SPDX-License-Identifier: MIT
#include "mscomp/base/random.h"

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Block = std::array<std::uint32_t, 4>;

Block philox(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
    Block x{static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32),
            static_cast<std::uint32_t>(stream), static_cast<std::uint32_t>(stream >> 32)};
    auto key0 = static_cast<std::uint32_t>(seed);
    auto key1 = static_cast<std::uint32_t>(seed >> 32);
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t p0 = std::uint64_t{0xD2511F53} * x[0];
        const std::uint64_t p1 = std::uint64_t{0xCD9E8D57} * x[2];
        x = {static_cast<std::uint32_t>(p1 >> 32) ^ x[1] ^ key0, static_cast<std::uint32_t>(p1),
             static_cast<std::uint32_t>(p0 >> 32) ^ x[3] ^ key1, static_cast<std::uint32_t>(p0)};
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
    return x;
}

std::uint64_t join(std::uint32_t low, std::uint32_t high) {
    return std::uint64_t{high} << 32 | low;
}

double to_unit(std::uint64_t bits) { return static_cast<double>(bits >> 11) * 0x1p-53; }

}  // namespace

std::uint64_t CounterRandom::bits(std::uint64_t index) const {
    const Block block = philox(seed_, stream_, index);
    return join(block[0], block[1]);
}

double CounterRandom::uniform(std::uint64_t index) const { return to_unit(bits(index)); }

double CounterRandom::normal(std::uint64_t index) const {
    const Block block = philox(seed_, stream_, index);
    // 1 - u lies in (0, 1], so the logarithm is finite.
    const double radius = std::sqrt(-2.0 * std::log(1.0 - to_unit(join(block[0], block[1]))));
    return radius * std::cos(2.0 * std::numbers::pi * to_unit(join(block[2], block[3])));
}

std::vector<int> CounterRandom::permutation(int count) const {
    std::vector<int> order(at(count));
    std::iota(order.begin(), order.end(), 0);
    for (int i = count - 1; i > 0; --i) {
        const int j = static_cast<int>(uniform(static_cast<std::uint64_t>(i)) * (i + 1));
        std::swap(order[at(i)], order[at(j)]);
    }
    return order;
}

}  // namespace mscomp
