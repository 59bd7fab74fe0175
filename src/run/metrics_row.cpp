// SPDX-License-Identifier: MIT
#include "mscomp/run/metrics_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "mscomp/base/parsed_number.h"

namespace mscomp {
namespace {

/// Milliseconds, thirty years: nothing takes longer, and sums over all steps stay finite.
constexpr double kLongestStep = 1e12;

std::string_view field(std::string_view row, int index) {
    if (index < 0) return row.substr(row.rfind(',') + 1);
    for (; index > 0 && !row.empty(); --index) {
        row.remove_prefix(std::min(row.find(','), row.size() - 1) + 1);
    }
    return row.substr(0, row.find(','));
}

template <class Number>
Number number_in(std::string_view row, int index, const FilePosition& where) {
    const std::string_view text = field(row, index);
    if (const auto number = parsed_number<Number>(text)) return *number;
    throw InputError(where, fmt::format("got '{}', wanted a number as training writes it", text));
}

}  // namespace

MetricsRow metrics_row(std::string_view text, const MetricsRow& before, const FilePosition& where) {
    MetricsRow row;
    row.epoch = number_in<std::int64_t>(text, 0, where);
    row.step = number_in<std::int64_t>(text, 1, where);
    row.step_ms = number_in<double>(text, -1, where);
    const bool is_sound = row.epoch > before.epoch && row.step >= before.step && row.step_ms >= 0 &&
                          row.step_ms <= kLongestStep;
    if (!is_sound) {
        throw InputError(where,
                         "wanted epochs and steps that ascend, and a time, as training "
                         "writes them");
    }
    return row;
}

}  // namespace mscomp
