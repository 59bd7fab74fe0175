// SPDX-License-Identifier: MIT
// Numbers within names of files.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/acap/mesh/natural_order.h"

namespace mscomp {

/// A decimal number of any length: 0.`digits` times 10^`exponent`, the first digit not 0; 0 has
/// none.
struct NameNumber {
    bool negative = false;
    std::int64_t exponent = 0;
    std::string digits;
};
std::strong_ordering operator<=>(const NameNumber& a, const NameNumber& b);

/// A name in turns: text (it may be empty), number, text, ..., text.
struct NamePieces {
    std::vector<std::string> texts;
    std::vector<NameNumber> numbers;  // one less than texts
};
NamePieces pieces_of(std::string_view name, const NumberReading& reading);
std::strong_ordering compare_pieces(const NamePieces& a, const NamePieces& b);

/// What the names of a set show about their numbers; see NaturalOrder.
class NumberEvidence {
  public:
    void add(std::string_view name);
    NumberReading reading() const;
    /// Whether numbers with a point could as well be read in the other way.
    bool is_in_doubt() const;

  private:
    /// Numbers behind the same text.
    struct Slot {
        bool has_whole = false, has_zero = false, begins_with_zero = false, ends_in_zero = false;
        std::set<std::size_t> lengths;  // of the fractions
    };
    static bool shows_fractions(const Slot& slot);
    static bool shows_counters(const Slot& slot);

    std::map<std::string, Slot> slots_;     // by the text before, '#' for each number
    std::set<std::string> before_hyphens_;  // texts before a hyphen and a number
    bool has_exponents_ = false, shows_exponents_ = false;
};

}  // namespace mscomp
