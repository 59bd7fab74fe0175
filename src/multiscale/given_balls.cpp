// SPDX-License-Identifier: MIT
#include "multiscale/given_balls.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

std::vector<int> counts_of(const GivenComponents& given) {
    std::vector<int> counts;
    for (const LevelSize& level : given.levels) counts.push_back(level.codes());
    return counts;
}

std::vector<int> counts_of(const MultiscaleSettings& settings) {
    std::vector<int> counts;
    if (settings.global_components > 0) counts.push_back(settings.global_components);
    for (const BallLevel& level : settings.levels) counts.push_back(level.components);
    return counts;
}

/// The next thousandth, the first at least.
double rounded_up(double part) { return std::clamp(std::ceil(1000 * part), 1.0, 1000.0) / 1000; }

}  // namespace

void require_levels(const GivenComponents& given, const MultiscaleSettings& settings) {
    if (counts_of(given) != counts_of(settings)) {
        throw UsageError(
            fmt::format("train.start: levels of {} components, wanted those of "
                        "model.global_components and model.levels: {}",
                        fmt::join(counts_of(given), ", "), fmt::join(counts_of(settings), ", ")));
    }
}

BallComponents given_balls(const GivenComponents& given, const RowMap& map) {
    std::vector<Ball> balls;
    for (std::size_t k = 0; k < given.changes.size(); ++k) {
        balls.push_back({given.centers[k], given.changes[k].vertices});
    }
    const auto width = at(map.width());
    BallComponents components(given.vertex_count, std::move(balls), map.width());
    for (int k = 0; k < components.count(); ++k) {
        const CodeColumn& change = given.changes[at(k)];
        std::vector<float> scaled(change.values);
        for (std::size_t i = 0; i < scaled.size(); ++i) {
            const double factor = map.factor(change.vertices[i / width], i % width);
            scaled[i] = static_cast<float>(static_cast<double>(scaled[i]) * factor);
        }
        components.set_component(k, scaled);
    }
    components.normalize();
    return components;
}

std::vector<BallLevel> levels_around(const GivenComponents& given, DistanceRows& distances) {
    distances.prepare(given.centers);
    std::vector<BallLevel> levels;
    std::size_t k = 0;
    for (const LevelSize& size : given.levels) {
        double range = 0, share = 0;
        for (const std::size_t end = k + at(size.codes()); k < end; ++k) {
            const std::span<const double> row = distances.row(given.centers[k]);
            const std::vector<int>& vertices = given.changes[k].vertices;
            for (const int v : vertices) range = std::max(range, row[at(v)]);
            share = std::max(
                share, static_cast<double>(vertices.size()) / static_cast<double>(row.size()));
        }
        levels.push_back({size.codes(), rounded_up(range), rounded_up(share)});
    }
    return levels;
}

}  // namespace mscomp
