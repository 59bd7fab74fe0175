// SPDX-License-Identifier: MIT
#include "nn/sparsity_rows.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "learning/reach.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

/// |C_i| of one component at `vertices`.
template <class T>
void measure(const T* component, std::span<const int> vertices, std::span<double> lengths) {
    for (std::size_t n = 0; n < lengths.size(); ++n) {
        const T* c = component + at(vertices[n]) * kFeatureDim;
        T square = 0;
        for (std::size_t i = 0; i < kFeatureDim; ++i) square += c[i] * c[i];
        // Most are exact zeros, and roots take time.
        lengths[n] = square > 0 ? std::sqrt(static_cast<double>(square)) : 0.0;
    }
}

}  // namespace

SparsityRows::SparsityRows(DistanceRows& distances, const LevelConfig& level, CenterRule rule,
                           const LevelSupports* supports)
    : distances_(distances), level_(level), rule_(rule), supports_(supports) {
    if (supports != nullptr) return;
    all_vertices_.resize(at(distances.vertex_count()));
    std::iota(all_vertices_.begin(), all_vertices_.end(), 0);
}

std::span<const int> SparsityRows::acting(std::int64_t row) const {
    if (supports_ == nullptr) return all_vertices_;
    return supports_->of(static_cast<int>(row / level_.components)).acting_vertices;
}

/// sum_i Lambda_i |C_i| of one component.
double SparsityRows::penalty(const SparsityRow& around, std::int64_t row) const {
    const std::span<const int> vertices = acting(row);
    const std::span<const double> length = lengths(row);
    double sum = 0;
    for (std::size_t n = 0; n < vertices.size(); ++n) {
        sum += around.weight(vertices[n]) * length[n];
    }
    return sum;
}

SparsityRow SparsityRows::row(int center) {
    const std::span<const double> distances = distances_.row(center);
    if (level_.sparsity_ramp) {
        return {distances, level_.sparsity_ramp->from, level_.sparsity_ramp->to};
    }
    const auto [known, is_new] = reaches_.try_emplace(center, 0.0);
    if (is_new) {
        // One tenth less than the range leaves room for the ring that the convolution adds around.
        const double share = level_.max_support.value_or(level_.sparsity_range);
        known->second = reach_of(distances, level_.sparsity_range, share);
    }
    return {distances, known->second, known->second};
}

template <class T>
const std::vector<SparsityRow>& SparsityRows::focus(std::span<const T> component_weights) {
    const auto vertices = at(distances_.vertex_count());
    const std::size_t count = component_weights.size() / (vertices * kFeatureDim);
    first_length_.assign(1, 0);
    for (std::size_t k = 0; k < count; ++k) {
        first_length_.push_back(first_length_.back() + acting(static_cast<std::int64_t>(k)).size());
    }
    lengths_.resize(first_length_.back());
    longest_.resize(count);
    centers_.resize(count, -1);
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t row) {
        const auto k = at(row);
        const std::span<const int> place = acting(row);
        const auto measured = std::span(lengths_).subspan(first_length_[k], place.size());
        measure(component_weights.data() + k * vertices * kFeatureDim, place, measured);
        const auto largest = std::max_element(measured.begin(), measured.end());
        // A component that acts nowhere stays where it is.
        longest_[k] =
            measured.empty() ? std::max(centers_[k], 0) : place[at(largest - measured.begin())];
    });

    // All that is asked for below, settled centres included, so that the spans outlive each other.
    prepared_.assign(longest_.begin(), longest_.end());
    if (rule_ == CenterRule::settle) {
        for (const int center : centers_) {
            if (center >= 0) prepared_.push_back(center);
        }
    }
    distances_.prepare(prepared_);
    rows_.resize(count);
    candidates_.resize(count);
    for (std::size_t k = 0; k < count; ++k) {
        if (rule_ == CenterRule::follow || centers_[k] < 0) centers_[k] = longest_[k];
        rows_[k] = row(centers_[k]);
        candidates_[k] = row(longest_[k]);
    }
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t index) {
        const auto k = at(index);
        if (centers_[k] == longest_[k]) return;
        if (penalty(candidates_[k], index) < penalty(rows_[k], index)) {
            centers_[k] = longest_[k];
            rows_[k] = candidates_[k];
        }
    });
    return rows_;
}

template const std::vector<SparsityRow>& SparsityRows::focus(std::span<const float>);
template const std::vector<SparsityRow>& SparsityRows::focus(std::span<const double>);

}  // namespace mscomp::nn
