// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace mscomp {

/// What a number at the start of a text was found to be.
struct NumberText {
    enum class Kind { finite, not_finite, too_large, none };
    Kind kind = Kind::none;
    double value = 0;           // nearest double; NaN or infinite where the text says so
    const char* end = nullptr;  // one past the last character used
};

/// Reads a decimal number (optional sign, point and exponent, never a comma) at `begin`. Exactly
/// the nearest double; numbers too small for a double become 0.
NumberText read_number(const char* begin, const char* end);

/// The characters of a token in quotes, made safe to print and cut to a readable length.
std::string quoted(std::string_view token);

/// "got '0,5' ..., expected ..." for a token that is not the finite number it has to be.
std::string number_complaint(std::string_view token);

}  // namespace mscomp
