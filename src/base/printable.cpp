// SPDX-License-Identifier: MIT
#include "mscomp/base/printable.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace mscomp {
namespace {

unsigned char byte_of(char c) { return static_cast<unsigned char>(c); }
bool continues(char c) { return (byte_of(c) & 0xc0U) == 0x80; }

/// A character at the beginning of a text, and how many bytes it has; none where it is no UTF-8.
struct Character {
    char32_t code = 0;
    std::size_t bytes = 0;
};

/// The shortest code that so many bytes may stand for: longer forms of shorter codes are no UTF-8.
char32_t least_code(std::size_t bytes) {
    if (bytes == 2) return 0x80;
    return bytes == 3 ? 0x800 : 0x10000;
}

Character first_character(std::string_view text) {
    const unsigned char lead = byte_of(text.front());
    if (lead < 0x80) return {lead, 1};
    if (lead < 0xc2 || lead > 0xf4) return {};
    const std::size_t bytes = lead < 0xe0 ? 2 : (lead < 0xf0 ? 3 : 4);
    if (text.size() < bytes) return {};
    char32_t code = lead & (0x7fU >> bytes);
    for (const char c : text.substr(1, bytes - 1)) {
        if (!continues(c)) return {};
        code = code << 6U | (byte_of(c) & 0x3fU);
    }
    const bool is_surrogate = 0xd800 <= code && code <= 0xdfff;
    if (code < least_code(bytes) || code > 0x10ffff || is_surrogate) return {};
    return {code, bytes};
}

bool is_control(char32_t code) {
    return code < 0x20 || (0x7f <= code && code <= 0x9f) || code == 0x2028 || code == 0x2029;
}

/// Marks, embeddings, overrides and isolates of the bidirectional algorithm.
bool reorders(char32_t code) {
    return code == 0x61c || code == 0x200e || code == 0x200f ||
           (0x202a <= code && code <= 0x202e) || (0x2066 <= code && code <= 0x2069);
}

bool is_shown(const Character& character) {
    return character.bytes > 0 && !is_control(character.code) && !reorders(character.code);
}

/// `text` with `replacement(character)` for what cannot be shown.
template <class Replacement>
std::string cleaned(std::string_view text, Replacement&& replacement) {
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const Character character = first_character(text);
        const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
        if (is_shown(character)) {
            result += text.substr(0, bytes);
        } else {
            result += replacement(character);
        }
        text.remove_prefix(bytes);
    }
    return result;
}

bool is_line_feed(const Character& character) {
    return character.bytes == 1 && character.code == '\n';
}

}  // namespace

std::string printable(std::string_view text) {
    return cleaned(text, [](const Character&) { return '?'; });
}

std::string printable_lines(std::string_view text) {
    return cleaned(text, [](const Character& c) { return is_line_feed(c) ? '\n' : '?'; });
}

std::string escaped_json(std::string_view json) {
    return cleaned(json, [](const Character& c) {
        if (is_line_feed(c)) return std::string(1, '\n');
        return c.bytes > 0 ? fmt::format("\\u{:04x}", static_cast<std::uint32_t>(c.code))
                           : std::string("\\ufffd");
    });
}

std::string_view whole_characters(std::string_view text, std::size_t count) {
    if (count >= text.size()) return text;
    while (count > 0 && continues(text[count])) --count;
    return text.substr(0, count);
}

}  // namespace mscomp
