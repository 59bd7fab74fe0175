// SPDX-License-Identifier: MIT
#include "mscomp/nn/sparsity_rows.h"

#include <algorithm>
#include <cmath>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

template <class T>
T squared_norm(const T* vector) {
    T sum = 0;
    for (int c = 0; c < kFeatureDim; ++c) sum += vector[c] * vector[c];
    return sum;
}

/// sum_i Lambda_i |C_i| of one component.
template <class T>
double penalty(const SparsityRow& row, const T* component) {
    double sum = 0;
    for (int v = 0; v < static_cast<int>(row.distances.size()); ++v) {
        const double lambda = row.weight(v);
        if (!(lambda > 0)) continue;
        sum += lambda * std::sqrt(static_cast<double>(squared_norm(component + v * kFeatureDim)));
    }
    return sum;
}

}  // namespace

double SparsityRow::weight(int vertex) const {
    const double distance = distances[static_cast<std::size_t>(vertex)];
    if (distance >= to) return 1;
    return distance <= from ? 0 : (distance - from) / (to - from);
}

SparsityRows::SparsityRows(DistanceRows& distances, const LevelConfig& level, CenterRule rule)
    : distances_(distances), level_(level), rule_(rule) {}

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

template <class T>
const std::vector<SparsityRow>& SparsityRows::focus(std::span<const T> component_weights) {
    const auto size = static_cast<std::size_t>(distances_.vertex_count()) * kFeatureDim;
    const std::size_t count = component_weights.size() / size;
    const std::vector<int> longest =
        longest_vertices(component_weights, static_cast<int>(count), distances_.vertex_count());
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
        const T* component = component_weights.data() + k * size;
        if (penalty(candidates[k], component) < penalty(rows_[k], component)) {
            centers_[k] = longest[k];
            rows_[k] = candidates[k];
        }
    });
    return rows_;
}

template <class T>
std::vector<int> longest_vertices(std::span<const T> component_weights, int rows,
                                  int vertex_count) {
    std::vector<int> longest(static_cast<std::size_t>(rows), 0);
    parallel_for(rows, [&](std::int64_t row) {
        const T* component = component_weights.data() + row * vertex_count * kFeatureDim;
        T largest = -1;
        for (int v = 0; v < vertex_count; ++v) {
            const T length = squared_norm(component + v * kFeatureDim);
            if (length > largest) {
                largest = length;
                longest[static_cast<std::size_t>(row)] = v;
            }
        }
    });
    return longest;
}

template const std::vector<SparsityRow>& SparsityRows::focus(std::span<const float>);
template const std::vector<SparsityRow>& SparsityRows::focus(std::span<const double>);
template std::vector<int> longest_vertices(std::span<const float>, int, int);
template std::vector<int> longest_vertices(std::span<const double>, int, int);

}  // namespace mscomp::nn
