// SPDX-License-Identifier: MIT
#include "multiscale/metric_rows.h"

namespace mscomp {

void MetricRows::set(int m, std::span<const float> row) {
    float* to = values_.data() + m;
    for (const float value : row) {
        *to = value;
        to += shapes_;
    }
}

std::vector<float> MetricRows::row(int m) const {
    std::vector<float> row(at(vertices_) * at(width_));
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = value(i, m);
    return row;
}

}  // namespace mscomp
