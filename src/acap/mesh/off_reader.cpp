// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "polygon_mesh.h"
#include "text_cursor.h"

namespace mscomp {
namespace {

constexpr std::string_view kKind = "an OFF mesh";

/// One vertex or face per line; blank lines and comments may stand between.
class OffReader {
  public:
    OffReader(std::string_view text, const std::string& path)
        : cursor_(text, text_begin(text, path, kKind), 1, path) {}

    PolygonMesh read() {
        read_keyword();
        read_counts();
        mesh_.vertices.reserve(at(vertex_count_));
        mesh_.ends.reserve(at(face_count_));
        mesh_.corners.reserve(at(3 * face_count_));
        for (std::int64_t i = 0; i < vertex_count_; ++i) read_vertex(i);
        for (std::int64_t i = 0; i < face_count_; ++i) read_face(i);
        to_content();
        if (!cursor_.at_end()) {
            cursor_.fail(fmt::format("got {} after the last face, expected the end of the file",
                                     in_quotes(cursor_.token())));
        }
        return std::move(mesh_);
    }

  private:
    /// [ST][C][N]OFF, the prefixes in any order, each at most once.
    void read_keyword() {
        to_content();
        const std::string_view keyword = cursor_.token();
        std::string_view prefixes = keyword;
        if (!keyword.ends_with("OFF")) {
            cursor_.fail(
                fmt::format("got {}, expected 'OFF' (or COFF, NOFF, STOFF, ...) as the first word",
                            in_quotes(keyword)));
        }
        prefixes.remove_suffix(3);
        for (const std::string_view known : {"ST", "C", "N"}) {
            const std::size_t place = prefixes.find(known);
            if (place == 0) {
                prefixes.remove_prefix(known.size());
            } else if (place != std::string_view::npos && place + known.size() == prefixes.size()) {
                prefixes.remove_suffix(known.size());
            }
        }
        if (prefixes.find_first_of("4n") != std::string_view::npos) {
            cursor_.fail(fmt::format("got {}, points of another dimension; expected OFF with x y z",
                                     in_quotes(keyword)));
        }
        if (!prefixes.empty()) {
            cursor_.fail(
                fmt::format("got {}, expected OFF, with no other prefixes than ST, C and N",
                            in_quotes(keyword)));
        }
        cursor_.skip_token();
    }

    void read_counts() {
        to_content();
        if (cursor_.token() == "BINARY") {
            cursor_.fail("got a binary OFF file, expected a text one; save it as text, or as PLY");
        }
        const std::size_t bytes = cursor_.bytes_left();
        vertex_count_ = read_count("vertices");
        face_count_ = read_count("faces");
        // The number of edges is used by nobody and often left out or 0.
        cursor_.skip_blanks();
        if (!at_row_end()) whole_number("number of edges");
        end_row("the counts");
        check_fit(bytes);
    }

    std::int64_t read_count(std::string_view what) {
        cursor_.skip_blanks();
        if (at_row_end()) {
            cursor_.fail(fmt::format(
                "the line ends before the number of {}, expected vertices, faces and edges", what));
        }
        const std::int64_t count = whole_number(fmt::format("number of {}", what));
        if (count < 1 || count > std::numeric_limits<int>::max()) {
            cursor_.fail_taken(
                fmt::format("got {} {}, expected 1 to 2^31 - 1", cursor_.taken(), what));
        }
        return count;
    }

    /// Before anything is reserved: the shortest rows are "0 0 0" and "3 0 0 0" with their ends.
    void check_fit(std::size_t bytes) const {
        const auto wanted = static_cast<std::uint64_t>(6 * vertex_count_ + 8 * face_count_);
        if (wanted <= bytes) return;
        cursor_.fail(
            fmt::format("got {} vertices and {} faces, expected no more than fit the {} bytes of "
                        "the file; it may be truncated",
                        vertex_count_, face_count_, bytes));
    }

    void read_vertex(std::int64_t index) {
        begin_row("vertices", index, vertex_count_);
        Point point;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            cursor_.skip_blanks();
            if (at_row_end()) {
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
        begin_row("faces", index, face_count_);
        const std::int64_t count = whole_number("number of corners");
        if (count < 3) {
            cursor_.fail_taken(
                fmt::format("got a face with {} corners, expected at least 3", count));
        }
        for (std::int64_t i = 0; i < count; ++i) {
            cursor_.skip_blanks();
            if (at_row_end()) {
                cursor_.fail(fmt::format("the face ends after {} of {} corners", i, count));
            }
            const std::int64_t corner = whole_number("face corner");
            if (corner < 0 || corner >= vertex_count_) {
                cursor_.fail_taken(
                    fmt::format("face refers to vertex {}, the file has {} (0 to {})",
                                cursor_.taken(), vertex_count_, vertex_count_ - 1));
            }
            mesh_.corners.push_back(static_cast<int>(corner));
        }
        mesh_.ends.push_back(mesh_.corners.size());
        skip_numbers("after the face");
    }

    /// Colours, normals, texture coordinates up to the end of the line; how many there are.
    int skip_numbers(std::string_view what) {
        int count = 0;
        for (cursor_.skip_blanks(); !at_row_end(); cursor_.skip_blanks()) {
            cursor_.take_number(what);
            ++count;
        }
        return count;
    }

    /// The whole number here; what does not fit becomes the largest or smallest that does.
    std::int64_t whole_number(std::string_view what) {
        const double value = cursor_.take_number(what);
        if (cursor_.taken().find_first_not_of("+-0123456789") != std::string_view::npos) {
            cursor_.fail_taken(fmt::format("{}: got {}, expected a whole number", what,
                                           in_quotes(cursor_.taken())));
        }
        constexpr double limit = 9e15;  // up to there doubles are exact
        return static_cast<std::int64_t>(std::clamp(value, -limit, limit));
    }

    void begin_row(std::string_view what, std::int64_t index, std::int64_t count) {
        to_content();
        if (!cursor_.at_end()) return;
        cursor_.fail(fmt::format("the file ends after {} of {} {}", index, count, what));
    }
    void end_row(std::string_view what) {
        cursor_.skip_blanks();
        if (!at_row_end()) {
            cursor_.fail(fmt::format("got {} after {}, expected the end of the line",
                                     in_quotes(cursor_.token()), what));
        }
    }
    bool at_row_end() const { return cursor_.at_line_end() || cursor_.at('#'); }

    /// Over blanks, line ends and comments.
    void to_content() {
        for (cursor_.skip_blanks(); !cursor_.at_end() && at_row_end(); cursor_.skip_blanks()) {
            cursor_.skip_to_line_end();
            if (!cursor_.at_end()) cursor_.next_line();
        }
    }

    TextCursor cursor_;
    PolygonMesh mesh_;
    std::int64_t vertex_count_ = 0, face_count_ = 0;
    std::optional<int> extra_numbers_;  // behind the coordinates of the first vertex
};

}  // namespace

PolygonMesh parse_off_polygons(std::string_view text, const std::string& path) {
    return OffReader(text, path).read();
}

}  // namespace mscomp
