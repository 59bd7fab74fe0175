// SPDX-License-Identifier: MIT
#include "mscomp/base/metric_scale.h"

#include <cstddef>

namespace mscomp {

void MetricScale::scale(std::span<float> features) const {
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        features[k] = static_cast<float>((static_cast<double>(features[k]) - offset[channel]) *
                                         (factor[channel] * root(k / kFeatureDim)));
    }
}

void MetricScale::unscale(std::span<float> features) const {
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        const double scaled = factor[channel] * root(k / kFeatureDim);
        const double deviation = scaled != 0 ? static_cast<double>(features[k]) / scaled : 0.0;
        features[k] = static_cast<float>(deviation + offset[channel]);
    }
}

void MetricScale::unscale_change(int v, std::span<float> values) const {
    for (std::size_t c = 0; c < values.size(); ++c) {
        values[c] = static_cast<float>(static_cast<double>(values[c]) * unscale_factor(at(v), c));
    }
}

}  // namespace mscomp
