// SPDX-License-Identifier: MIT
#include "cli/shape_files.h"

#include <fmt/format.h>

#include <charconv>
#include <set>
#include <utility>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

bool parse_bound(std::string_view text, int fallback, int& value) {
    value = fallback;
    if (text.empty()) return true;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
}

bool is_harmless(unsigned char c) { return c > 0x20 && c != '/' && c != '\\' && c != 0x7f; }

}  // namespace

ShapeRange parse_shape_range(std::string_view text, int shape_count) {
    const std::size_t colon = text.find(':');
    ShapeRange range;
    const bool is_sound = colon != std::string_view::npos &&
                          parse_bound(text.substr(0, colon), 0, range.begin) &&
                          parse_bound(text.substr(colon + 1), shape_count, range.end) &&
                          range.begin >= 0 && range.begin < range.end && range.end <= shape_count;
    if (!is_sound) {
        throw UsageError(
            fmt::format("--frames: got {}, wanted A:B with 0 <= A < B <= {}", text, shape_count));
    }
    return range;
}

std::vector<std::string> shape_file_names(const std::vector<std::string>& names) {
    std::vector<std::string> stems;
    for (const std::string& name : names) {
        std::string stem;
        for (const char c : name) stem += is_harmless(static_cast<unsigned char>(c)) ? c : '_';
        if (stem.starts_with('.')) stem[0] = '_';
        stems.push_back(std::move(stem));
    }
    const std::set<std::string> distinct(stems.begin(), stems.end());
    if (distinct.size() == stems.size() && !distinct.contains("")) return stems;
    for (std::size_t i = 0; i < stems.size(); ++i) stems[i] = fmt::format("{:04}_{}", i, stems[i]);
    return stems;
}

}  // namespace mscomp
