// SPDX-License-Identifier: MIT
#include "text_cursor.h"

#include <fmt/format.h>

#include "mscomp/base/error.h"

namespace mscomp {

void TextCursor::fail_token(std::string_view what) const {
    fail(fmt::format("{}: {}", what, number_complaint(token())));
}

void TextCursor::fail_at(const char* place, std::string_view message) const {
    throw InputError({*path_, line_, place - line_begin_ + 1}, message);
}

std::string_view without_padding(std::string_view text) {
    using namespace std::string_view_literals;
    const std::size_t last = text.find_last_not_of("\0\x1a \t\r\n"sv);
    const std::size_t behind = last == std::string_view::npos ? 0 : last + 1;
    const std::size_t padding = text.substr(behind).find_first_of("\0\x1a"sv);
    return padding == std::string_view::npos ? text : text.substr(0, behind + padding);
}

}  // namespace mscomp
