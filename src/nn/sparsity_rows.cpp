// SPDX-License-Identifier: MIT
#include "mscomp/nn/sparsity_rows.h"

#include <algorithm>

namespace mscomp::nn {

double SparsityRow::weight(int vertex) const {
    const double distance = distances[static_cast<std::size_t>(vertex)];
    if (distance >= to) return 1;
    return distance <= from ? 0 : (distance - from) / (to - from);
}

SparsityRows::SparsityRows(DistanceRows& distances, const LevelConfig& level)
    : distances_(distances), level_(level) {}

double SparsityRows::reach(std::span<const double> distances) const {
    const double part = level_.max_support.value_or(level_.sparsity_range);
    const auto most = static_cast<std::size_t>(part * static_cast<double>(distances.size()));
    if (most >= distances.size()) return level_.sparsity_range;
    // Exactly the vertices nearer than the one after the last that fits are free.
    std::vector<double> sorted(distances.begin(), distances.end());
    const auto first_outside = sorted.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(sorted.begin(), first_outside, sorted.end());
    return std::min(level_.sparsity_range, *first_outside);
}

SparsityRow SparsityRows::row(int center) {
    const std::span<const double> distances = distances_.row(center);
    if (level_.sparsity_ramp) {
        return {distances, level_.sparsity_ramp->from, level_.sparsity_ramp->to};
    }
    const auto [known, is_new] = reaches_.try_emplace(center, 0.0);
    if (is_new) known->second = reach(distances);
    return {distances, known->second, known->second};
}

std::vector<SparsityRow> SparsityRows::rows(std::span<const int> centers) {
    distances_.prepare(centers);
    std::vector<SparsityRow> rows;
    rows.reserve(centers.size());
    for (const int center : centers) rows.push_back(row(center));
    return rows;
}

}  // namespace mscomp::nn
