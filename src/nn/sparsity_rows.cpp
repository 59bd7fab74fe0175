// SPDX-License-Identifier: MIT
#include "mscomp/nn/sparsity_rows.h"

#include <algorithm>
#include <cmath>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

/// |C_i| of one component, (V).
template <class T>
void measure(const T* component, std::span<double> lengths) {
    for (std::size_t v = 0; v < lengths.size(); ++v) {
        double square = 0;
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const auto x = static_cast<double>(component[v * kFeatureDim + c]);
            square += x * x;
        }
        lengths[v] = std::sqrt(square);
    }
}

/// sum_i Lambda_i |C_i| of one component.
double penalty(const SparsityRow& row, std::span<const double> lengths) {
    double sum = 0;
    for (std::size_t v = 0; v < lengths.size(); ++v) {
        sum += row.weight(static_cast<int>(v)) * lengths[v];
    }
    return sum;
}

}  // namespace

SparsityRows::SparsityRows(DistanceRows& distances, const LevelConfig& level, CenterRule rule)
    : distances_(distances), level_(level), rule_(rule) {}

double SparsityRows::reach(std::span<const double> distances) const {
    // One tenth less than the range leaves room for the ring that the convolution adds around.
    const double part = level_.max_support.value_or(0.9 * level_.sparsity_range);
    const auto most = std::max<std::size_t>(
        1, static_cast<std::size_t>(part * static_cast<double>(distances.size())));
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

template <class T>
const std::vector<SparsityRow>& SparsityRows::focus(std::span<const T> component_weights) {
    const auto vertices = static_cast<std::size_t>(distances_.vertex_count());
    const std::size_t count = component_weights.size() / (vertices * kFeatureDim);
    lengths_.resize(count * vertices);
    std::vector<int> longest(count);
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t k) {
        const auto row =
            std::span(lengths_).subspan(static_cast<std::size_t>(k) * vertices, vertices);
        measure(component_weights.data() + static_cast<std::size_t>(k) * vertices * kFeatureDim,
                row);
        longest[static_cast<std::size_t>(k)] =
            static_cast<int>(std::max_element(row.begin(), row.end()) - row.begin());
    });

    centers_.resize(count, -1);
    distances_.prepare(longest);
    rows_.resize(count);
    std::vector<SparsityRow> candidates;
    for (std::size_t k = 0; k < count; ++k) {
        if (rule_ == CenterRule::follow || centers_[k] < 0) centers_[k] = longest[k];
        rows_[k] = row(centers_[k]);
        candidates.push_back(row(longest[k]));
    }
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t index) {
        const auto k = static_cast<std::size_t>(index);
        if (centers_[k] == longest[k]) return;
        const std::span<const double> length = lengths(index);
        if (penalty(candidates[k], length) < penalty(rows_[k], length)) {
            centers_[k] = longest[k];
            rows_[k] = candidates[k];
        }
    });
    return rows_;
}

template const std::vector<SparsityRow>& SparsityRows::focus(std::span<const float>);
template const std::vector<SparsityRow>& SparsityRows::focus(std::span<const double>);

}  // namespace mscomp::nn
