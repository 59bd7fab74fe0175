// SPDX-License-Identifier: MIT
#include "number_text.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <system_error>

namespace mscomp {
namespace {

bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

// 10^0 .. 10^22 are exact doubles.
constexpr int kLargestExactPower = 22;
constexpr std::array<double, kLargestExactPower + 1> kPowersOfTen{
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
constexpr std::uint64_t kLargestExactInteger = std::uint64_t{1} << 53;
constexpr int kDigitsThatFit = 19;  // any 19 digits fit 64 bits

/// The usual short number, digits and a point: integer and power of ten are both exact doubles, so
/// one division rounds correctly. Leaves everything else to read_any_number.
bool read_short_number(const char* at, const char* end, NumberText& number) {
    const bool negative = at != end && *at == '-';
    if (negative) ++at;
    const char* const digits_begin = at;
    std::uint64_t digits = 0;
    while (at != end && is_digit(*at)) digits = 10 * digits + static_cast<unsigned>(*at++ - '0');
    std::ptrdiff_t digit_count = at - digits_begin;
    std::ptrdiff_t decimals = 0;
    if (at != end && *at == '.') {
        const char* const decimals_begin = ++at;
        while (at != end && is_digit(*at))
            digits = 10 * digits + static_cast<unsigned>(*at++ - '0');
        decimals = at - decimals_begin;
        digit_count += decimals;
    }
    if (digit_count == 0 || digit_count > kDigitsThatFit || digits > kLargestExactInteger)
        return false;
    if (at != end && (*at == 'e' || *at == 'E')) return false;
    const double size =
        static_cast<double>(digits) / kPowersOfTen[static_cast<std::size_t>(decimals)];
    number = {NumberText::Kind::finite, negative ? -size : size, at};
    return true;
}

NumberText read_any_number(const char* begin, const char* end) {
    NumberText number;
    auto [after, error] = std::from_chars(begin, end, number.value);
    if (error == std::errc::invalid_argument) return number;
    number.end = after;
    number.kind =
        std::isfinite(number.value) ? NumberText::Kind::finite : NumberText::Kind::not_finite;
    if (error == std::errc::result_out_of_range) {
        long double wide = 0;
        const bool fits_wide = std::from_chars(begin, end, wide).ec == std::errc{};
        const bool tiny = fits_wide && std::abs(wide) < 1.0L;
        number.value = 0;
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

NumberText read_number(const char* begin, const char* end) {
    NumberText number;
    if (read_short_number(begin, end, number)) return number;
    // A leading plus is harmless but unknown to from_chars; "+-1" stays an error.
    if (begin != end && *begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;
    return read_any_number(begin, end);
}

std::string quoted(std::string_view token) {
    constexpr std::size_t longest = 40;
    std::string text = "'";
    for (const char c : token.substr(0, longest)) {
        const auto code = static_cast<unsigned char>(c);
        text += code < 0x20 || code == 0x7f ? '?' : c;
    }
    return text += token.size() > longest ? "...'" : "'";
}

std::string number_complaint(std::string_view token) {
    const char* const end = token.data() + token.size();
    const NumberText number = read_number(token.data(), end);
    const bool whole = number.end == end;
    if (whole && number.kind == NumberText::Kind::not_finite) {
        return fmt::format("got {}, expected a finite number", quoted(token));
    }
    if (whole && number.kind == NumberText::Kind::too_large) {
        return fmt::format("got {}, expected a number not beyond 1.8e308", quoted(token));
    }
    if (has_decimal_comma(token)) {
        return fmt::format(
            "got {} with a decimal comma, expected a number with a decimal point such as 0.5",
            quoted(token));
    }
    return fmt::format("got {}, expected a number", quoted(token));
}

}  // namespace mscomp
