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

}  // namespace mscomp
