// SPDX-License-Identifier: MIT
#include "number_text.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <system_error>

namespace mscomp {
namespace {

NumberText read_with_library(const char* begin, const char* end) {
    NumberText number;
    auto [after, error] = std::from_chars(begin, end, number.value);
    if (error == std::errc::invalid_argument) return number;
    number.end = after;
    number.kind =
        std::isfinite(number.value) ? NumberText::Kind::finite : NumberText::Kind::not_finite;
    if (error == std::errc::result_out_of_range) {
        // from_chars does not say whether it is too large or too small; the C library does.
        const double limit = std::strtod(std::string(begin, after).c_str(), nullptr);
        const bool tiny = std::abs(limit) < 1;
        number.value = tiny ? limit : 0;
        number.kind = tiny ? NumberText::Kind::finite : NumberText::Kind::too_large;
    }
    return number;
}

bool has_decimal_comma(std::string_view token) {
    for (std::size_t i = 1; i + 1 < token.size(); ++i) {
        if (token[i] == ',' && is_digit(token[i - 1]) && is_digit(token[i + 1])) return true;
    }
    return false;
}

}  // namespace

namespace detail {

NumberText read_any_number(const char* begin, const char* end) {
    // A leading plus is harmless but unknown to from_chars; "+-1" stays an error.
    if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
    return read_with_library(begin, end);
}

}  // namespace detail

std::string in_quotes(std::string_view token) {
    constexpr std::size_t longest = 40;
    std::string text = "'";
    for (const char c : token.substr(0, longest)) {
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x20 || code == 0x7f) {
            text += fmt::format("\\x{:02x}", code);
        } else {
            text += c;
        }
    }
    return text += token.size() > longest ? "...'" : "'";
}

std::string number_complaint(std::string_view token) {
    const char* const end = token.data() + token.size();
    const NumberText number = read_number(token.data(), end);
    const bool whole = number.end == end;
    if (whole && number.kind == NumberText::Kind::not_finite) {
        return fmt::format("got {}, expected a finite number", in_quotes(token));
    }
    if (whole && number.kind == NumberText::Kind::too_large) {
        return fmt::format("got {}, expected a number not beyond 1.8e308", in_quotes(token));
    }
    if (token.find(kByteOrderMark) != std::string_view::npos) {
        return fmt::format(
            "got {} behind a byte order mark (BOM), expected a number; save the file as UTF-8 "
            "without BOM",
            in_quotes(token.substr(token.find(kByteOrderMark) + kByteOrderMark.size())));
    }
    if (has_decimal_comma(token)) {
        return fmt::format(
            "got {} with a decimal comma, expected a number with a decimal point such as 0.5",
            in_quotes(token));
    }
    return fmt::format("got {}, expected a number", in_quotes(token));
}

}  // namespace mscomp
