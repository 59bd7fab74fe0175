// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "off_header.h"
#include "off_tokens.h"
#include "polygon_mesh.h"
#include "text_cursor.h"

namespace mscomp {
namespace {

constexpr std::string_view kKind = "an OFF mesh";

/// The rows behind the header: one vertex or face per line; blank lines and comments may stand
/// between.
class OffRows {
  public:
    OffRows(TextCursor cursor, const OffHeader& header) : cursor_(cursor), header_(header) {}

    PolygonMesh read() {
        end_row("the counts");
        mesh_.vertices.reserve(at(header_.vertex_count));
        mesh_.ends.reserve(at(header_.face_count));
        mesh_.corners.reserve(at(3 * header_.face_count));
        for (std::int64_t i = 0; i < header_.vertex_count; ++i) read_vertex(i);
        for (std::int64_t i = 0; i < header_.face_count; ++i) read_face(i);
        skip_to_off_content(cursor_);
        if (!cursor_.at_end()) {
            cursor_.fail(fmt::format("got {} after the last face, expected the end of the file",
                                     in_quotes(cursor_.token())));
        }
        if (mesh_.ends.empty()) cursor_.fail("has no faces of three corners or more");
        return std::move(mesh_);
    }

  private:
    void read_vertex(std::int64_t index) {
        begin_row("vertices", index, header_.vertex_count);
        Point point;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            cursor_.skip_blanks();
            if (at_off_row_end(cursor_)) {
                cursor_.fail(fmt::format("the vertex ends after {} coordinate{}, expected 3", axis,
                                         axis == 1 ? "" : "s"));
            }
            const double value = cursor_.take_number(kCoordinates[axis]);
            if (!std::isfinite(value)) {
                cursor_.fail_taken(
                    fmt::format("{}: {}", kCoordinates[axis], number_complaint(cursor_.taken())));
            }
            point[axis] = value;
        }
        mesh_.vertices.push_back(point);
        check_extra_numbers(skip_numbers("after the vertex"));
    }

    /// A count that is too large would take the first face for a vertex; its length gives it away.
    void check_extra_numbers(int count) {
        if (!extra_numbers_) extra_numbers_ = count;
        if (count != *extra_numbers_) {
            cursor_.fail(fmt::format("got a vertex line of {} numbers, expected {} as in the first",
                                     count + 3, *extra_numbers_ + 3));
        }
    }

    void read_face(std::int64_t index) {
        begin_row("faces", index, header_.face_count);
        const std::int64_t count = take_whole_number(cursor_, "number of corners");
        if (count < 0) {
            cursor_.fail_taken(
                fmt::format("got a face with {} corners, expected at least 3", count));
        }
        for (std::int64_t i = 0; i < count; ++i) {
            cursor_.skip_blanks();
            if (at_off_row_end(cursor_)) {
                cursor_.fail(fmt::format("the face ends after {} of {} corners", i, count));
            }
            const std::int64_t corner = take_whole_number(cursor_, "face corner");
            if (corner < 0 || corner >= header_.vertex_count) {
                cursor_.fail_taken(
                    fmt::format("face refers to vertex {}, the file has {} (0 to {})",
                                cursor_.taken(), header_.vertex_count, header_.vertex_count - 1));
            }
            mesh_.corners.push_back(static_cast<int>(corner));
        }
        mesh_.finish_face([&] { return fmt::format("line {}", cursor_.line()); });
        if (skip_numbers("after the face") > 0) mesh_.leave_unused("face colours");
    }

    /// Colours, normals, texture coordinates up to the end of the line; how many there are.
    int skip_numbers(std::string_view what) {
        int count = 0;
        for (cursor_.skip_blanks(); !at_off_row_end(cursor_); cursor_.skip_blanks()) {
            cursor_.take_number(what);
            ++count;
        }
        return count;
    }

    void begin_row(std::string_view what, std::int64_t index, std::int64_t count) {
        skip_to_off_content(cursor_);
        if (!cursor_.at_end()) return;
        cursor_.fail(fmt::format("the file ends after {} of {} {}", index, count, what));
    }
    void end_row(std::string_view what) {
        cursor_.skip_blanks();
        if (!at_off_row_end(cursor_)) {
            cursor_.fail(fmt::format("got {} after {}, expected the end of the line",
                                     in_quotes(cursor_.token()), what));
        }
    }

    TextCursor cursor_;
    const OffHeader& header_;
    PolygonMesh mesh_;
    std::optional<int> extra_numbers_;  // behind the coordinates of the first vertex
};

/// As lines where every line is a row, which is how nearly all files are; else as a stream.
PolygonMesh read_rows(const TextCursor& cursor, const OffHeader& header) {
    try {
        return OffRows(cursor, header).read();
    } catch (const InputError&) {
        if (auto mesh = read_off_tokens(cursor, header)) return std::move(*mesh);
        throw;
    }
}

}  // namespace

PolygonMesh parse_off_polygons(std::string_view text, const std::string& path) {
    const std::size_t begin = text_begin(text, path, kKind);
    TextCursor cursor(without_padding(text.substr(begin)), 0, 1, path);
    const OffHeader header = read_off_header(cursor);
    PolygonMesh mesh = read_rows(cursor, header);
    if (header.has_colors) mesh.leave_unused("vertex colours");
    if (header.has_normals) mesh.leave_unused("normals");
    if (header.has_texture) mesh.leave_unused("texture coordinates");
    return mesh;
}

}  // namespace mscomp
