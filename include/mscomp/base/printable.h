// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace mscomp {

/// Text of unknown origin (file names, names in files, option values) as one line that can be shown
/// and logged: UTF-8 without control characters (C0, DEL, C1, line and paragraph separators) and
/// without those that reorder what stands around them; '?' stands for each of these, and for each
/// byte that is no UTF-8. What is printable already comes back as it is.
std::string printable(std::string_view text);

/// The same for text of several lines: line feeds stay.
std::string printable_lines(std::string_view text);

/// JSON with an escape for each character that `printable` would replace. Such characters stand in
/// strings only; the text must be UTF-8 and its control characters below 0x20 escaped already.
std::string escaped_json(std::string_view json);

/// The first `count` bytes of UTF-8 text, less where they would end within a character.
std::string_view whole_characters(std::string_view text, std::size_t count);

}  // namespace mscomp
