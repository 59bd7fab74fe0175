// SPDX-License-Identifier: MIT
#include "learning/mixed_features.h"

#include <algorithm>
#include <cmath>

#include "learning/deflation.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

constexpr int kFewestPatches = 4, kMostPatches = 40;
constexpr float kBlend = 0.05F;
constexpr double kFirstWay = -0.1, kLastWay = 1.1;
/// Streams of random numbers for mixing, away from those of start, batches and noise.
constexpr std::uint64_t kMixStreams = std::uint64_t{1} << 61;

}  // namespace

MixedFeatures::MixedFeatures(const ShapeFeatures& features, std::span<const int> shapes,
                             DistanceRows& distances, std::span<const int> to_user,
                             std::uint64_t seed, double between)
    : features_(features), shapes_(shapes.begin(), shapes.end()), seed_(seed), between_(between) {
    for (const int middle : spread_vertices(distances, kCandidates)) {
        const std::span<const double> row = distances.row(middle);
        std::vector<float>& user = middles_.emplace_back(row.size());
        for (std::size_t v = 0; v < row.size(); ++v) {
            user[at(to_user[v])] = static_cast<float>(row[v]);
        }
    }
}

MixedFeatures::Mix MixedFeatures::mix(int m) const {
    const CounterRandom random(seed_, kMixStreams + static_cast<std::uint64_t>(m));
    const int most = std::min(kMostPatches, static_cast<int>(middles_.size()));
    const int fewest = std::min(kFewestPatches, most);
    const int patches =
        fewest + static_cast<int>(random.uniform(0) * static_cast<double>(most - fewest + 1));
    const std::vector<int> order =
        CounterRandom(seed_, kMixStreams + (std::uint64_t{1} << 40) + static_cast<std::uint64_t>(m))
            .permutation(static_cast<int>(middles_.size()));
    const auto drawn_shape = [&](std::uint64_t index) {
        const double drawn = random.uniform(index) * static_cast<double>(shapes_.size());
        return shapes_[at(static_cast<std::int64_t>(drawn))];
    };
    Mix result;
    for (int p = 0; p < patches; ++p) {
        // The numbers drawn for patch p, none of them drawn for anything else.
        const std::uint64_t follows = static_cast<std::uint64_t>(p) + 1;
        const std::uint64_t also = follows + kMostPatches, is_between = also + kMostPatches,
                            way = is_between + kMostPatches;
        result.shapes.push_back(drawn_shape(follows));
        const bool has_two = random.uniform(is_between) < between_;
        result.others.push_back(has_two ? drawn_shape(also) : result.shapes.back());
        result.ways.push_back(
            has_two ? static_cast<float>(kFirstWay + (kLastWay - kFirstWay) * random.uniform(way))
                    : 0.0F);
    }
    result.weights.resize(at(std::int64_t{vertex_count()} * patches));
    for (std::int64_t v = 0; v < vertex_count(); ++v) {
        float* weights = result.weights.data() + v * patches;
        float nearest = middles_[at(order[0])][at(v)];
        for (int p = 0; p < patches; ++p) {
            weights[p] = middles_[at(order[at(p)])][at(v)];
            nearest = std::min(nearest, weights[p]);
        }
        float sum = 0;
        for (int p = 0; p < patches; ++p) {
            const float beyond = (weights[p] - nearest) / kBlend;
            weights[p] = beyond > 8 ? 0 : std::exp(-beyond);
            sum += weights[p];
        }
        for (int p = 0; p < patches; ++p) weights[p] /= sum;
    }
    return result;
}

std::vector<float> MixedFeatures::mixed_row(int m) const {
    const Mix parts = mix(m);
    const std::size_t patches = parts.shapes.size();
    std::vector<std::span<const float>> sources, others;
    for (const int shape : parts.shapes) sources.push_back(features_.shape(shape));
    for (const int shape : parts.others) others.push_back(features_.shape(shape));
    std::vector<float> row(at(std::int64_t{vertex_count()} * kFeatureDim), 0.0F);
    for (std::size_t v = 0; v < at(vertex_count()); ++v) {
        for (std::size_t p = 0; p < patches; ++p) {
            const float weight = parts.weights[v * patches + p];
            if (weight == 0) continue;
            const float way = parts.ways[p];
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                const float from = sources[p][v * kFeatureDim + c];
                const float change = way == 0 ? 0 : others[p][v * kFeatureDim + c] - from;
                row[v * kFeatureDim + c] += weight * (from + way * change);
            }
        }
    }
    return row;
}

std::span<const float> MixedFeatures::shape(int index) const {
    const int count = features_.shape_count();
    if (index < count) return features_.shape(index);
    return rows_.row(index, [&] { return mixed_row(index - count); });
}

void MixedFeatures::forget(int index) const {
    if (index < features_.shape_count()) return features_.forget(index);
    rows_.forget(index);
}

}  // namespace mscomp
