// SPDX-License-Identifier: MIT
#include "multiscale/metric_rows.h"

#include <algorithm>

#include "mscomp/base/feature_set.h"

namespace mscomp {

void MetricScale::map(std::span<const float> features, std::span<float> to) const {
    std::ranges::copy(features, to.begin());
    scale_.scale(to);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] *= roots_[i / kFeatureDim];
}

void MetricScale::unmap(std::span<float> row) const {
    for (std::size_t i = 0; i < row.size(); ++i) row[i] /= roots_[i / kFeatureDim];
    scale_.unscale(row);
}

void MetricScale::unmap_change(int v, std::span<float> values) const {
    for (std::size_t c = 0; c < values.size(); ++c) {
        values[c] = static_cast<float>(static_cast<double>(values[c]) * unmap_factor(v, c));
    }
}

void MetricRows::set(int m, std::span<const float> row) {
    float* to = values_.data() + m;
    for (const float value : row) {
        *to = value;
        to += shapes_;
    }
}

}  // namespace mscomp
