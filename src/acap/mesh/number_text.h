// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "mscomp/base/index.h"

namespace mscomp {

/// What a coordinate is called in messages.
inline constexpr std::array<std::string_view, 3> kCoordinates{
    "vertex coordinate x", "vertex coordinate y", "vertex coordinate z"};

/// What some editors begin UTF-8 with; nothing shows it.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }

/// What a number at the start of a text was found to be.
struct NumberText {
    enum class Kind { finite, not_finite, too_large, none };
    Kind kind = Kind::none;
    double value = 0;           // nearest double; NaN or infinite where the text says so
    const char* end = nullptr;  // one past the last character used
};

/// Reads a decimal number (optional sign, point and exponent, never a comma) at `begin`. Exactly
/// the nearest double; numbers too small for a double become 0.
inline NumberText read_number(const char* begin, const char* end);

/// The characters of a token in quotes, cut to a readable length; control characters as \x00.
std::string in_quotes(std::string_view token);

/// "got '0,5' ..., expected ..." for a token that is not the finite number it has to be.
std::string number_complaint(std::string_view token);

namespace detail {

inline constexpr std::array<double, 20> kPowersOfTen{1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,
                                                     1e7,  1e8,  1e9,  1e10, 1e11, 1e12, 1e13,
                                                     1e14, 1e15, 1e16, 1e17, 1e18, 1e19};

/// Reads all digits at `at` behind those already in `value` (modulo 2^64) and returns how many.
inline std::ptrdiff_t read_digits_one_by_one(const char*& place, const char* end,
                                             std::uint64_t& value) {
    const char* const begin = place;
    while (place != end && is_digit(*place))
        value = 10 * value + static_cast<unsigned>(*place++ - '0');
    return place - begin;
}

/// The same, the first eight characters in one step: where lengths vary, a loop over the characters
/// is mispredicted for every number.
inline std::ptrdiff_t read_digits(const char*& place, const char* end, std::uint64_t& value) {
    static_assert(std::endian::native == std::endian::little, "the first character comes lowest");
    constexpr std::array<std::uint64_t, 9> powers{1,      10,      100,      1000,     10000,
                                                  100000, 1000000, 10000000, 100000000};
    if (end - place < 8) return read_digits_one_by_one(place, end, value);
    std::uint64_t word = 0;
    std::memcpy(&word, place, 8);
    word ^= 0x3030303030303030U;  // digits become 0 .. 9
    const std::uint64_t others = (word | (word + 0x7676767676767676U)) & 0x8080808080808080U;
    const int count = std::countr_zero(others) / 8;
    // Leading zeros; in two steps, as none may be 64.
    word = word << (32 - 4 * count) << (32 - 4 * count);
    word = (10 * word + (word >> 8)) & 0x00FF00FF00FF00FFU;
    word = (100 * word + (word >> 16)) & 0x0000FFFF0000FFFFU;
    word = (10000 * word + (word >> 32)) & 0x00000000FFFFFFFFU;
    value = powers[at(count)] * value + word;
    place += count;
    return count + read_digits_one_by_one(place, end, value);
}

/// The usual short number, digits and a point: integer and power of ten are both exact doubles, so
/// one division rounds correctly. Leaves everything else to read_any_number.
inline bool read_short_number(const char* place, const char* end, NumberText& number) {
    constexpr std::uint64_t largest_exact_integer = std::uint64_t{1} << 53;
    constexpr std::ptrdiff_t digits_that_fit = 19;  // any 19 digits fit 64 bits
    const bool negative = place != end && *place == '-';
    place += negative ? 1 : 0;
    std::uint64_t digits = 0;
    std::ptrdiff_t digit_count = read_digits_one_by_one(place, end, digits);
    std::ptrdiff_t decimals = 0;
    if (place != end && *place == '.') {
        decimals = read_digits(++place, end, digits);
        digit_count += decimals;
    }
    if (digit_count == 0 || digit_count > digits_that_fit || digits > largest_exact_integer ||
        (place != end && (*place == 'e' || *place == 'E'))) {
        return false;
    }
    const double size = static_cast<double>(digits) / kPowersOfTen[at(decimals)];
    // Signs cannot be predicted: set the bit instead of choosing.
    const std::uint64_t sign = std::uint64_t{negative} << 63;
    number = {NumberText::Kind::finite,
              std::bit_cast<double>(std::bit_cast<std::uint64_t>(size) | sign), place};
    return true;
}

NumberText read_any_number(const char* begin, const char* end);

}  // namespace detail

inline NumberText read_number(const char* begin, const char* end) {
    NumberText number;
    if (detail::read_short_number(begin, end, number)) return number;
    return detail::read_any_number(begin, end);
}

}  // namespace mscomp
