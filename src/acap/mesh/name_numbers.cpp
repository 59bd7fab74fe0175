// SPDX-License-Identifier: MIT
#include "name_numbers.h"

#include <algorithm>
#include <charconv>

#include "number_text.h"

namespace mscomp {
namespace {

/// Where the parts of a number end that begins at a digit; an absent part ends where the one before
/// it does.
struct NumberExtent {
    std::size_t whole_end = 0, fraction_end = 0, exponent_end = 0;
};

char char_at(std::string_view name, std::size_t at) { return at < name.size() ? name[at] : '\0'; }

std::size_t digits_end(std::string_view name, std::size_t at) {
    while (is_digit(char_at(name, at))) ++at;
    return at;
}

bool is_word(char c) { return is_digit(c) || ('a' <= (c | 0x20) && (c | 0x20) <= 'z'); }

/// One point only: what has more is a version or a date.
std::size_t fraction_end(std::string_view name, std::size_t begin, std::size_t whole_end) {
    const bool follows_point = begin >= 2 && name[begin - 1] == '.' && is_digit(name[begin - 2]);
    if (follows_point || char_at(name, whole_end) != '.') return whole_end;
    const std::size_t end = digits_end(name, whole_end + 1);
    const bool has_more = char_at(name, end) == '.' && is_digit(char_at(name, end + 1));
    return end == whole_end + 1 || has_more ? whole_end : end;
}

std::size_t exponent_end(std::string_view name, std::size_t begin) {
    if ((char_at(name, begin) | 0x20) != 'e') return begin;
    const char sign = char_at(name, begin + 1);
    const std::size_t first = begin + (sign == '-' || sign == '+' ? 2 : 1);
    const std::size_t end = digits_end(name, first);
    return end == first || is_word(char_at(name, end)) ? begin : end;
}

NumberExtent extent_of(std::string_view name, std::size_t begin) {
    NumberExtent extent;
    extent.whole_end = digits_end(name, begin);
    extent.fraction_end = fraction_end(name, begin, extent.whole_end);
    extent.exponent_end = exponent_end(name, extent.fraction_end);
    return extent;
}

std::int64_t exponent_in(std::string_view text) {
    if (text.starts_with('+')) text.remove_prefix(1);
    constexpr std::int64_t huge = 1'000'000'000;
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range) value = text.starts_with('-') ? -huge : huge;
    return std::clamp(value, -huge, huge);
}

NameNumber number_of(std::string_view whole, std::string_view fraction, std::string_view exponent,
                     bool negative) {
    NameNumber number;
    number.digits = std::string(whole) + std::string(fraction);
    const std::size_t zeros = std::min(number.digits.find_first_not_of('0'), number.digits.size());
    number.digits.erase(0, zeros);
    number.digits.erase(number.digits.find_last_not_of('0') + 1);
    if (number.digits.empty()) return number;
    number.negative = negative;
    number.exponent = static_cast<std::int64_t>(whole.size()) - static_cast<std::int64_t>(zeros) +
                      (exponent.empty() ? 0 : exponent_in(exponent));
    return number;
}

bool is_sign(std::string_view name, std::size_t at) {
    return (char_at(name, at) == '-' || char_at(name, at) == '+') &&
           is_digit(char_at(name, at + 1));
}

/// Whether a sign is one whatever other names are like.
bool is_clear_sign(std::string_view name, std::size_t at) {
    return at == 0 || name[at - 1] == '_' || name[at - 1] == '.' || name[at - 1] == '=';
}

/// Calls use(begin of the digits, text before with '#' for each number) for runs of digits.
template <class Use>
void for_each_run(std::string_view name, Use&& use) {
    std::string before;
    for (std::size_t at = 0; at < name.size();) {
        if (!is_digit(name[at])) {
            before += name[at++];
            continue;
        }
        use(at, before);
        before += '#';
        at = digits_end(name, at);
    }
}

}  // namespace

std::strong_ordering operator<=>(const NameNumber& a, const NameNumber& b) {
    const auto sign_of = [](const NameNumber& x) {
        return x.digits.empty() ? 0 : x.negative ? -1 : 1;
    };
    if (sign_of(a) != sign_of(b) || sign_of(a) == 0) return sign_of(a) <=> sign_of(b);
    const auto size = a.exponent != b.exponent ? a.exponent <=> b.exponent : a.digits <=> b.digits;
    if (std::is_eq(size) || !a.negative) return size;
    return std::is_lt(size) ? std::strong_ordering::greater : std::strong_ordering::less;
}

NamePieces pieces_of(std::string_view name, const NumberReading& reading) {
    NamePieces pieces;
    std::string text, before;
    for (std::size_t at = 0; at < name.size();) {
        const bool negated =
            is_sign(name, at) && (is_clear_sign(name, at) || reading.negated.contains(before));
        if (!negated && !is_digit(name[at])) {
            text += name[at];
            before += name[at++];
            continue;
        }
        const std::size_t begin = negated ? at + 1 : at;
        const NumberExtent extent = extent_of(name, begin);
        const std::size_t whole = extent.whole_end;
        std::string_view fraction, exponent;
        at = whole;
        if (reading.decimals) {
            at = extent.exponent_end;
            const std::size_t end = extent.fraction_end;
            if (end > whole) fraction = name.substr(whole + 1, end - whole - 1);
            if (at > end) exponent = name.substr(end + 1, at - end - 1);
        }
        pieces.texts.push_back(std::move(text));
        pieces.numbers.push_back(number_of(name.substr(begin, whole - begin), fraction, exponent,
                                           negated && name[begin - 1] == '-'));
        text.clear();
        before += '#';
    }
    pieces.texts.push_back(std::move(text));
    return pieces;
}

std::strong_ordering compare_pieces(const NamePieces& a, const NamePieces& b) {
    for (std::size_t i = 0; i < a.texts.size() && i < b.texts.size(); ++i) {
        // A number stands among characters where digits do.
        const auto with_digit = [i](const NamePieces& pieces) {
            return i < pieces.numbers.size() ? pieces.texts[i] + "0" : pieces.texts[i];
        };
        const std::string x = with_digit(a), y = with_digit(b);
        if (x != y) return std::string_view(x) <=> std::string_view(y);
        if (i == a.numbers.size()) return std::strong_ordering::equal;
        if (const auto order = a.numbers[i] <=> b.numbers[i]; std::is_neq(order)) return order;
    }
    return std::strong_ordering::equal;
}

void NumberEvidence::add(std::string_view name) {
    for_each_run(name, [&](std::size_t begin, const std::string& before) {
        if (begin > 0 && is_sign(name, begin - 1)) {
            before_hyphens_.insert(before.substr(0, before.size() - 1));
        }
        const NumberExtent extent = extent_of(name, begin);
        const bool follows_point =
            begin >= 2 && name[begin - 1] == '.' && is_digit(name[begin - 2]);
        if (follows_point) return;
        Slot& slot = slots_[before];
        const std::string_view whole = name.substr(begin, extent.whole_end - begin);
        if (extent.exponent_end > extent.fraction_end) {
            has_exponents_ = true;
            shows_exponents_ = shows_exponents_ || extent.fraction_end > extent.whole_end ||
                               !is_digit(name[extent.fraction_end + 1]);
        }
        if (extent.fraction_end == extent.whole_end) {
            slot.has_whole = slot.has_whole || char_at(name, extent.whole_end) != '.';
            return;
        }
        const std::string_view fraction =
            name.substr(extent.whole_end + 1, extent.fraction_end - extent.whole_end - 1);
        const bool is_zero = fraction.find_first_not_of('0') == std::string_view::npos;
        slot.has_zero = slot.has_zero || (is_zero && fraction.size() == 1) ||
                        whole.find_first_not_of('0') == std::string_view::npos;
        if (fraction.size() > 1) {
            slot.begins_with_zero = slot.begins_with_zero || fraction.front() == '0';
            slot.ends_in_zero = slot.ends_in_zero || fraction.back() == '0';
        }
        slot.lengths.insert(fraction.size());
    });
}

bool NumberEvidence::shows_fractions(const Slot& slot) {
    return !slot.lengths.empty() && !slot.ends_in_zero &&
           (slot.has_whole || slot.has_zero || slot.begins_with_zero);
}

bool NumberEvidence::shows_counters(const Slot& slot) {
    return slot.lengths.size() > 1 && slot.ends_in_zero && !slot.begins_with_zero;
}

NumberReading NumberEvidence::reading() const {
    NumberReading reading;
    bool fractions = shows_exponents_, counters = false;
    for (const auto& [before, slot] : slots_) {
        fractions = fractions || shows_fractions(slot);
        counters = counters || shows_counters(slot);
    }
    reading.decimals = fractions && !counters;
    for (const std::string& before : before_hyphens_) {
        if (slots_.contains(before)) reading.negated.insert(before);
    }
    return reading;
}

bool NumberEvidence::is_in_doubt() const {
    if (reading().decimals) return false;
    if (has_exponents_) return true;
    return std::any_of(slots_.begin(), slots_.end(), [](const auto& entry) {
        const Slot& slot = entry.second;
        return slot.lengths.size() > 1 && !shows_counters(slot);
    });
}

}  // namespace mscomp
