// SPDX-License-Identifier: MIT
#include "generate_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

std::vector<float> draw_weights(const std::vector<Mover>& movers, int frames, std::uint64_t seed) {
    const std::size_t count = movers.size();
    const auto coarse =
        at(std::ranges::count_if(movers, [](const Mover& mover) { return mover.scale == 0; }));
    const std::vector<int> slow = CounterRandom(seed, 0).permutation(static_cast<int>(coarse));
    const std::vector<int> fast =
        CounterRandom(seed, 1).permutation(static_cast<int>(count - coarse));
    const CounterRandom phases(seed, 2);
    std::vector<float> weights(at(frames) * count, 0.0F);
    for (std::size_t k = 0; k < count; ++k) {
        const int frequency =
            k < coarse ? 1 + slow[k] : 1 + static_cast<int>(coarse) + fast[k - coarse];
        const double lowest = movers[k].lowest_weight;
        // A whole frame is hit by the crest, so that every component reaches its full weight.
        const double crest = std::floor(phases.uniform(k) * (frames - 1));
        for (int n = 1; n < frames; ++n) {
            const double angle = 2 * std::numbers::pi * frequency * (n - 1 - crest) / (frames - 1);
            weights[at(n) * count + k] =
                static_cast<float>(lowest + (1 - lowest) * 0.5 * (1 + std::cos(angle)));
        }
    }
    return weights;
}

}  // namespace

void require_size(std::string_view generator, int frames, int vertices) {
    constexpr int kMostFrames = 1'000'000, kMostVertices = 20'000'000;
    if (frames < 2 || frames > kMostFrames) {
        throw UsageError(
            fmt::format("{}: {} frames, wanted 2 to {}", generator, frames, kMostFrames));
    }
    if (vertices < 100 || vertices > kMostVertices) {
        throw UsageError(
            fmt::format("{}: {} vertices, wanted 100 to {}", generator, vertices, kMostVertices));
    }
}

GeneratedSequence still_sequence(const std::vector<Mover>& movers, int frames, std::uint64_t seed) {
    GeneratedSequence result;
    for (const Mover& mover : movers) {
        result.component_names.emplace_back(mover.name);
        result.scales.push_back(mover.scale);
    }
    result.weights = draw_weights(movers, frames, seed);
    result.sequence.shapes.resize(at(frames));
    for (int n = 0; n < frames; ++n) result.sequence.names.push_back(fmt::format("frame_{:04}", n));
    return result;
}

}  // namespace mscomp
