// SPDX-License-Identifier: MIT
#include "mscomp/run/metrics_row.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "mscomp/base/parsed_number.h"

namespace mscomp {
namespace {

std::string_view field(std::string_view row, int index) {
    if (index < 0) return row.substr(row.rfind(',') + 1);
    for (; index > 0 && !row.empty(); --index) {
        row.remove_prefix(std::min(row.find(','), row.size() - 1) + 1);
    }
    return row.substr(0, row.find(','));
}

}  // namespace

template <class Number>
Number metrics_number(std::string_view row, int index, const FilePosition& where) {
    const std::string_view text = field(row, index);
    if (const auto number = parsed_number<Number>(text)) return *number;
    throw InputError(where, fmt::format("got '{}', wanted a number as training writes it", text));
}

template std::int64_t metrics_number(std::string_view, int, const FilePosition&);
template double metrics_number(std::string_view, int, const FilePosition&);

}  // namespace mscomp
