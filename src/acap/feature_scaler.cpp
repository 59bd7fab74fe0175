// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_scaler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr double kRange = 0.95;

/// The group of a channel: r or S.
std::size_t group_of(std::size_t channel) { return channel < kRotationDim ? 0 : 1; }

struct ShapeRange {
    std::array<float, kFeatureDim> smallest, largest;
    bool is_finite = true;
};

ShapeRange range_of(std::span<const float> values) {
    ShapeRange range;
    range.smallest.fill(std::numeric_limits<float>::infinity());
    range.largest.fill(-std::numeric_limits<float>::infinity());
    bool is_finite = true;
    for (std::size_t v = 0; v < values.size(); v += kFeatureDim) {
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const float x = values[v + c];
            range.smallest[c] = std::min(range.smallest[c], x);
            range.largest[c] = std::max(range.largest[c], x);
            is_finite &= std::abs(x) <= std::numeric_limits<float>::max();
        }
    }
    range.is_finite = is_finite;
    return range;
}

[[noreturn]] void fail_not_finite(std::span<const float> values, int shape) {
    const auto place = at(std::ranges::find_if(values, [](float x) { return !std::isfinite(x); }) -
                          values.begin());
    throw NumericalError(fmt::format("feature of shape {}, vertex {}, channel {} is not finite",
                                     shape, place / kFeatureDim, place % kFeatureDim));
}

/// The first place of `value` in the channels of a group.
FeatureExtreme first_of(std::span<const float> values, float value, std::size_t group, int shape) {
    for (std::size_t k = 0; k < values.size(); ++k) {
        if (values[k] == value && group_of(k % kFeatureDim) == group) {
            return {values[k], shape, static_cast<int>(k / kFeatureDim),
                    static_cast<int>(k % kFeatureDim)};
        }
    }
    return {value, shape, -1, -1};
}

/// Features are stored in float32: what deviates less than this is rounding, not deformation, and
/// must not be blown up to the full range.
constexpr double kLeastRange = 1e-5;

double factor_for(double largest) { return largest > kLeastRange ? kRange / largest : 0.0; }

}  // namespace

FeatureRanges::FeatureRanges(const ShapeFeatures& features, std::span<const int> shapes,
                             std::vector<float> roots)
    : roots_(std::move(roots)), largest_(at(features.vertex_count()), 0.0) {
    if (shapes.empty()) throw UsageError("feature scaling needs at least one training shape");
    for (const int shape : shapes) {
        if (shape < 0 || shape >= features.shape_count()) {
            throw UsageError(fmt::format("training shape {}: the set has shapes 0 to {}", shape,
                                         features.shape_count() - 1));
        }
        add(features.shape(shape), shape);
        features.forget(shape);
    }
}

void FeatureRanges::add(std::span<const float> values, int shape) {
    const ShapeRange range = range_of(values);
    if (!range.is_finite) fail_not_finite(values, shape);
    add_deviations(values);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
        Group& group = groups_[g];
        const auto first = static_cast<std::ptrdiff_t>(g == 0 ? 0 : kRotationDim);
        const auto last = static_cast<std::ptrdiff_t>(g == 0 ? kRotationDim : kFeatureDim);
        const float smallest =
            *std::min_element(range.smallest.begin() + first, range.smallest.begin() + last);
        const float largest =
            *std::max_element(range.largest.begin() + first, range.largest.begin() + last);
        if (group.smallest.shape < 0 || smallest < group.smallest.value) {
            group.smallest = first_of(values, smallest, g, shape);
        }
        if (group.largest.shape < 0 || largest > group.largest.value) {
            group.largest = first_of(values, largest, g, shape);
        }
    }
}

void FeatureRanges::add_deviations(std::span<const float> values) {
    for (std::size_t v = 0; v < largest_.size(); ++v) {
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const double reference = kReferenceFeature[c];
            const double deviation =
                root(v) * std::abs(static_cast<double>(values[v * kFeatureDim + c]) - reference);
            double& of_group = groups_[group_of(c)].deviation;
            of_group = std::max(of_group, deviation);
            largest_[v] = std::max(largest_[v], deviation);
        }
    }
}

double FeatureRanges::robust_deviation() const {
    constexpr double kLeftOut = 0.001;
    std::vector<int> order(largest_.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order,
                             [&](int a, int b) { return largest_[at(a)] > largest_[at(b)]; });
    const auto weight = [&](int v) { return root(at(v)) * root(at(v)); };
    double whole = 0, larger = 0;
    for (const int v : order) whole += weight(v);
    for (const int v : order) {
        larger += weight(v);
        if (larger > kLeftOut * whole) return largest_[at(v)];
    }
    return 0;
}

FeatureScaler FeatureRanges::scaler(FeatureCenter center, FeatureScale scale) const {
    FeatureScaler scaler;
    scaler.center = center;
    for (const Group& group : groups_) {
        scaler.extremes.push_back(group.smallest);
        scaler.extremes.push_back(group.largest);
    }
    const bool at_reference = center == FeatureCenter::reference;
    for (std::size_t channel = 0; channel < kFeatureDim; ++channel) {
        const Group& group = groups_[group_of(channel)];
        const auto smallest = static_cast<double>(group.smallest.value);
        const auto largest = static_cast<double>(group.largest.value);
        scaler.offset[channel] =
            at_reference ? kReferenceFeature[channel] : 0.5 * (smallest + largest);
        scaler.factor[channel] =
            factor_for(at_reference ? group.deviation : 0.5 * (largest - smallest));
    }
    if (at_reference) scaler.roots = roots_;
    if (at_reference && scale != FeatureScale::separate) {
        const double shared =
            factor_for(scale == FeatureScale::robust
                           ? robust_deviation()
                           : std::max(groups_.front().deviation, groups_.back().deviation));
        for (double& factor : scaler.factor) factor = factor != 0 ? shared : 0;
    }
    return scaler;
}

FeatureScaler FeatureScaler::fit(const FeatureSet& set, std::span<const int> shapes,
                                 FeatureCenter center) {
    return FeatureRanges(MemoryFeatures(set.features, set.vertex_count()), shapes).scaler(center);
}

}  // namespace mscomp
