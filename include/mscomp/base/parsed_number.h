// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace mscomp {

/// The number that `text` is from its first character to its last, whatever the locale; nothing if
/// it is none or does not fit. Of a floating-point type it may be infinite or NaN.
template <class Number>
std::optional<Number> parsed_number(std::string_view text) {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [after, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || after != end) return std::nullopt;
    return value;
}

}  // namespace mscomp
