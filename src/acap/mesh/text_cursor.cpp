// SPDX-License-Identifier: MIT
#include "text_cursor.h"

#include <fmt/format.h>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace std::string_view_literals;

/// By the mark at its start or, where there is none, by the zeros between ASCII characters.
std::string_view wide_encoding(std::string_view bytes) {
    if (bytes.starts_with("\xFF\xFE\0\0"sv) || bytes.starts_with("\0\0\xFE\xFF"sv)) return "UTF-32";
    if (bytes.starts_with("\xFF\xFE"sv) || bytes.starts_with("\xFE\xFF"sv)) return "UTF-16";
    if (bytes.size() < 4) return "";
    const bool high_first = bytes[0] == 0 && bytes[1] != 0 && bytes[2] == 0 && bytes[3] != 0;
    const bool low_first = bytes[0] != 0 && bytes[1] == 0 && bytes[2] != 0 && bytes[3] == 0;
    return high_first || low_first ? "UTF-16" : "";
}

}  // namespace

void TextCursor::fail_token(std::string_view what) const {
    fail(fmt::format("{}: {}", what, number_complaint(token())));
}

void TextCursor::fail_at(const char* place, std::string_view message) const {
    throw InputError({path_, line_, place - line_begin_ + 1}, message);
}

std::size_t text_begin(std::string_view bytes, const std::string& path, std::string_view kind) {
    if (bytes.empty())
        throw InputError({path}, fmt::format("the file is empty, expected {}", kind));
    if (const std::string_view encoding = wide_encoding(bytes); !encoding.empty()) {
        throw InputError({path, 1, 1},
                         fmt::format("got {} text, expected {} in ASCII or UTF-8", encoding, kind));
    }
    return bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0;
}

}  // namespace mscomp
