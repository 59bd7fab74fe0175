// SPDX-License-Identifier: MIT
#include "off_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace mscomp {
namespace {

/// The prefixes of the keyword, which it takes off `word`. Throws InputError.
std::string_view take_keyword(TextCursor& cursor) {
    const std::string_view word = cursor.token();
    const std::size_t end = word.find_last_not_of("0123456789") + 1;
    const std::string_view keyword = word.substr(0, end);
    if (!keyword.ends_with("OFF") && keyword != "off" && keyword != "Off") {
        cursor.fail(
            fmt::format("got {}, expected 'OFF' (or COFF, NOFF, STOFF, ...) as the first word",
                        in_quotes(word)));
    }
    return keyword.substr(0, keyword.size() - 3);
}

bool take_prefix(std::string_view& prefixes, std::string_view known) {
    const std::size_t place = prefixes.find(known);
    if (place == std::string_view::npos) return false;
    if (place == 0) {
        prefixes.remove_prefix(known.size());
    } else if (place + known.size() == prefixes.size()) {
        prefixes.remove_suffix(known.size());
    } else {
        return false;
    }
    return true;
}

void read_keyword(TextCursor& cursor, OffHeader& header) {
    skip_to_off_content(cursor);
    std::string_view prefixes = take_keyword(cursor);
    const std::size_t length = prefixes.size() + 3;
    const std::string_view keyword = cursor.token().substr(0, length);
    header.has_texture = take_prefix(prefixes, "ST");
    header.has_colors = take_prefix(prefixes, "C");
    header.has_normals = take_prefix(prefixes, "N");
    if (prefixes.find_first_of("4n") != std::string_view::npos) {
        cursor.fail(fmt::format("got {}, points of another dimension; expected OFF with x y z",
                                in_quotes(keyword)));
    }
    if (!prefixes.empty()) {
        cursor.fail(fmt::format("got {}, expected OFF, with no other prefixes than ST, C and N",
                                in_quotes(keyword)));
    }
    cursor.skip(length);
}

std::int64_t read_count(TextCursor& cursor, std::string_view what) {
    skip_to_off_content(cursor);
    if (cursor.at_end()) {
        cursor.fail(fmt::format(
            "the file ends before the number of {}, expected vertices, faces and edges", what));
    }
    const std::int64_t count = take_whole_number(cursor, fmt::format("number of {}", what));
    if (count < 1 || count > std::numeric_limits<int>::max()) {
        cursor.fail_taken(fmt::format("got {} {}, expected 1 to 2^31 - 1", cursor.taken(), what));
    }
    return count;
}

/// Whether a line holds one word only.
bool is_alone(TextCursor cursor) {
    cursor.skip_token();
    cursor.skip_blanks();
    return at_off_row_end(cursor);
}

/// The number of edges is used by nobody and often left out or 0.
void skip_edges(TextCursor& cursor, bool counts_are_on_lines) {
    cursor.skip_blanks();
    if (at_off_row_end(cursor)) {
        if (!counts_are_on_lines) return;
        TextCursor next = cursor;
        skip_to_off_content(next);
        if (next.at_end() || !is_alone(next)) return;
        cursor = next;
    }
    take_whole_number(cursor, "number of edges");
}

/// Before anything is reserved: the shortest rows are "0 0 0" and "0" with their ends.
void check_fit(const TextCursor& cursor, const OffHeader& header, std::size_t bytes) {
    const auto wanted = static_cast<std::uint64_t>(6 * header.vertex_count + 2 * header.face_count);
    if (wanted <= bytes) return;
    cursor.fail(
        fmt::format("got {} vertices and {} faces, expected no more than fit the {} bytes of "
                    "the file; it may be truncated",
                    header.vertex_count, header.face_count, bytes));
}

}  // namespace

void skip_to_off_content(TextCursor& cursor) {
    for (cursor.skip_blanks(); !cursor.at_end() && at_off_row_end(cursor); cursor.skip_blanks()) {
        cursor.skip_to_line_end();
        if (!cursor.at_end()) cursor.next_line();
    }
}

std::int64_t take_whole_number(TextCursor& cursor, std::string_view what) {
    const double value = cursor.take_number(what);
    if (cursor.taken().find_first_not_of("+-0123456789") != std::string_view::npos) {
        cursor.fail_taken(
            fmt::format("{}: got {}, expected a whole number", what, in_quotes(cursor.taken())));
    }
    constexpr double limit = 9e15;  // up to there doubles are exact
    return static_cast<std::int64_t>(std::clamp(value, -limit, limit));
}

OffHeader read_off_header(TextCursor& cursor) {
    OffHeader header;
    read_keyword(cursor, header);
    skip_to_off_content(cursor);
    if (cursor.token() == "BINARY") {
        cursor.fail("got a binary OFF file, expected a text one; save it as text, or as PLY");
    }
    const std::size_t bytes = cursor.bytes_left();
    header.vertex_count = read_count(cursor, "vertices");
    const std::int64_t line = cursor.line();
    header.face_count = read_count(cursor, "faces");
    skip_edges(cursor, cursor.line() != line);
    check_fit(cursor, header, bytes);
    cursor.skip_blanks();
    header.data_follow_at_once = !at_off_row_end(cursor);
    return header;
}

}  // namespace mscomp
