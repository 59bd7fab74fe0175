// SPDX-License-Identifier: MIT
#include "utf8.h"

#include <array>

namespace mscomp {
namespace {

constexpr char32_t kReplacement = 0xFFFD;
// Smallest character of one to four bytes: what is written longer than needed is no UTF-8.
constexpr std::array<char32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};

bool is_character(char32_t c) { return c < 0xD800 || (c > 0xDFFF && c <= 0x10FFFF); }

std::size_t length_of(unsigned char first) {
    if (first < 0x80) return 1;
    if ((first & 0xE0) == 0xC0) return 2;
    if ((first & 0xF0) == 0xE0) return 3;
    if ((first & 0xF8) == 0xF0) return 4;
    return 0;
}

/// The character at the start of `text` and how many bytes it takes; one byte if there is none.
char32_t take_character(std::string_view text, std::size_t& length) {
    const auto first = static_cast<unsigned char>(text.front());
    const std::size_t wanted = length_of(first);
    length = 1;
    if (wanted == 1) return first;
    if (wanted == 0 || wanted > text.size()) return kReplacement;
    char32_t value = first & (0x7FU >> wanted);
    for (std::size_t i = 1; i < wanted; ++i) {
        const auto next = static_cast<unsigned char>(text[i]);
        if ((next & 0xC0) != 0x80) return kReplacement;
        value = value << 6 | (next & 0x3F);
    }
    if (value < kSmallest[wanted] || !is_character(value)) return kReplacement;
    length = wanted;
    return value;
}

}  // namespace

std::u32string from_utf8(std::string_view text) {
    std::u32string characters;
    for (std::size_t at = 0, length = 0; at < text.size(); at += length) {
        characters += take_character(text.substr(at), length);
    }
    return characters;
}

std::string to_utf8(std::u32string_view characters) {
    std::string text;
    for (char32_t c : characters) {
        if (!is_character(c)) c = kReplacement;
        std::size_t length = 4;
        while (length > 1 && c < kSmallest[length]) --length;
        constexpr std::array<unsigned, 5> marks{0, 0, 0xC0, 0xE0, 0xF0};
        for (std::size_t i = length; i-- > 0;) {
            const unsigned bits = c >> (6 * i) & (i + 1 == length ? 0x7FU : 0x3FU);
            text += static_cast<char>(bits | (i + 1 == length ? marks[length] : 0x80U));
        }
    }
    return text;
}

}  // namespace mscomp
