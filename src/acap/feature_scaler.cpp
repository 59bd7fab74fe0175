// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_scaler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

constexpr double kRange = 0.95;

bool is_rotation(int channel) { return channel < kRotationDim; }

/// Smallest and largest value, and the largest distance from the reference's feature, of the r or
/// of the S channels.
struct GroupRange {
    FeatureExtreme smallest, largest;
    double deviation = 0;

    void add(float value, int shape, int vertex, int channel) {
        if (smallest.shape < 0 || value < smallest.value)
            smallest = {value, shape, vertex, channel};
        if (largest.shape < 0 || value > largest.value) largest = {value, shape, vertex, channel};
        const double reference = kReferenceFeature[static_cast<std::size_t>(channel)];
        deviation = std::max(deviation, std::abs(static_cast<double>(value) - reference));
    }
    double middle() const {
        return 0.5 * (static_cast<double>(smallest.value) + static_cast<double>(largest.value));
    }
    double half_width() const {
        return 0.5 * (static_cast<double>(largest.value) - static_cast<double>(smallest.value));
    }
};

/// Features are stored in float32: what deviates less than this is rounding, not deformation, and
/// must not be blown up to the full range.
constexpr double kRounding = 1e-5;

double factor_for(double largest) { return largest > kRounding ? kRange / largest : 0.0; }

}  // namespace

FeatureScaler FeatureScaler::fit(const FeatureSet& set, std::span<const int> shapes,
                                 FeatureCenter center) {
    if (shapes.empty()) throw UsageError("feature scaling needs at least one training shape");
    GroupRange rotation, stretch;
    for (const int shape : shapes) {
        if (shape < 0 || shape >= set.shape_count()) {
            throw UsageError(fmt::format("training shape {}: the set has shapes 0 to {}", shape,
                                         set.shape_count() - 1));
        }
        const std::span<const float> values = set.shape(shape);
        for (std::size_t k = 0; k < values.size(); ++k) {
            const int vertex = static_cast<int>(k / kFeatureDim);
            const int channel = static_cast<int>(k % kFeatureDim);
            if (!std::isfinite(values[k])) {
                throw NumericalError(
                    fmt::format("feature of shape {}, vertex {}, channel {} is not finite", shape,
                                vertex, channel));
            }
            (is_rotation(channel) ? rotation : stretch).add(values[k], shape, vertex, channel);
        }
    }
    FeatureScaler scaler;
    scaler.center = center;
    scaler.extremes = {rotation.smallest, rotation.largest, stretch.smallest, stretch.largest};
    for (std::size_t channel = 0; channel < kFeatureDim; ++channel) {
        const GroupRange& group = is_rotation(static_cast<int>(channel)) ? rotation : stretch;
        const bool at_reference = center == FeatureCenter::reference;
        scaler.offset[channel] = at_reference ? kReferenceFeature[channel] : group.middle();
        scaler.factor[channel] = factor_for(at_reference ? group.deviation : group.half_width());
    }
    return scaler;
}

void FeatureScaler::scale(std::span<float> features) const {
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        features[k] = static_cast<float>((static_cast<double>(features[k]) - offset[channel]) *
                                         factor[channel]);
    }
}

void FeatureScaler::unscale(std::span<float> features) const {
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        const double deviation =
            factor[channel] != 0 ? static_cast<double>(features[k]) / factor[channel] : 0.0;
        features[k] = static_cast<float>(deviation + offset[channel]);
    }
}

}  // namespace mscomp
