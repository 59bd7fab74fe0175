// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "text_cursor.h"

namespace mscomp {

/// What an OFF file says of itself.
struct OffHeader {
    bool has_colors = false, has_normals = false, has_texture = false;  // of the vertices
    std::int64_t vertex_count = 0, face_count = 0;
    bool data_follow_at_once = false;  // on the line of the counts
};

/// Reads [ST][C][N]OFF, the prefixes in any order, and the counts; the first may follow at once
/// ("OFF4 4 0") and the number of edges may be left out. Leaves the cursor behind the counts.
/// Throws InputError.
OffHeader read_off_header(TextCursor& cursor);

/// Over blanks, line ends and comments.
void skip_to_off_content(TextCursor& cursor);
inline bool at_off_row_end(const TextCursor& cursor) {
    return cursor.at_line_end() || cursor.at('#');
}

/// The whole number here; what does not fit becomes the largest or smallest that does.
std::int64_t take_whole_number(TextCursor& cursor, std::string_view what);

}  // namespace mscomp
