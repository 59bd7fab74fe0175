// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

#include "mscomp/base/error.h"

namespace mscomp {

/// What a row of metrics.csv says of the way that training went.
struct MetricsRow {
    std::int64_t epoch = 0, step = 0;
    double step_ms = 0;
};

/// A row that stands at `where`, behind `before`. Throws InputError for one that training does not
/// write: no numbers, or not behind the one before.
MetricsRow metrics_row(std::string_view row, const MetricsRow& before, const FilePosition& where);

}  // namespace mscomp
