// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "number_text.h"
#include "obj_cursor.h"
#include "obj_statements.h"
#include "polygon_mesh.h"

namespace mscomp {
namespace {

constexpr std::ptrdiff_t kDigitsThatFit = 18;  // a signed number of 64 bits holds any of them
constexpr std::array<std::string_view, 3> kCoordinateNames{"x", "y", "z"};

/// One pass over the text.
class ObjReader : private ObjCursor {
  public:
    ObjReader(std::string_view whole, const std::string& path) : ObjCursor(whole, path) {
        const std::size_t size = at(end_ - at_);
        // About what a triangle mesh needs: 30 bytes a vertex, 18 a face, two faces a vertex.
        mesh_.vertices.reserve(size / 64);
        mesh_.ends.reserve(size / 32);
        mesh_.corners.reserve(size / 11);
    }

    PolygonMesh read() {
        for (skip_blanks(); at_ != end_; skip_blanks()) {
            if (is_line_end(*at_)) {
                next_line();
            } else {
                read_statement();
            }
        }
        check_complete();
        for (const std::string_view unused : statements_.unused()) mesh_.leave_unused(unused);
        return std::move(mesh_);
    }

  private:
    struct ForwardReference {
        std::int64_t index, line, column;
        std::string_view text;
    };

    void read_statement() {
        const char second = at_ + 1 == end_ ? '\n' : at_[1];
        const bool one_letter = is_blank(second) || is_line_end(second) || is_continuation(at_ + 1);
        if (*at_ == 'v' && one_letter) {
            ++at_;
            if (!read_plain_vertex()) read_vertex();
        } else if (*at_ == 'f' && one_letter) {
            ++at_;
            if (!read_plain_triangle()) read_face();
        } else if (*at_ == '#') {
            skip_comment();
        } else if (token() == "fo") {
            at_ += 2;  // "fo" is what faces were called in the first versions of the format
            read_face();
        } else {
            skip_other_statement();
        }
    }

    void skip_other_statement() {
        const std::string_view keyword = token();
        if (!statements_.note_known(keyword)) note_unknown(keyword);
        skip_statement();
    }

    void note_unknown(std::string_view keyword) {
        const std::string complaint = ObjStatements::complaint_about(keyword);
        if (!ObjStatements::may_be_foreign(keyword)) fail(complaint);
        if (unknown_complaint_.empty()) {
            unknown_complaint_ = complaint;
            unknown_place_ = here();
        }
        mesh_.pass_over(PassedOver::Kind::unknown_statement,
                        [&] { return fmt::format("line {}: {}", line_, in_quotes(keyword)); });
    }

    /// The usual line, three short numbers and nothing else, without the detours of read_vertex.
    bool read_plain_vertex() {
        const char* place = at_;
        Point point;
        for (double& coordinate : point) {
            while (place != end_ && is_blank(*place)) ++place;
            NumberText number;
            if (!detail::read_short_number(place, end_, number)) return false;
            coordinate = number.value;
            place = number.end;
            if (place == end_ || !(is_blank(*place) || is_line_end(*place))) return false;
        }
        if (!is_line_end(*place)) return false;
        at_ = place;
        mesh_.vertices.push_back(point);
        return true;
    }

    /// Likewise three plain indices of vertices already read.
    bool read_plain_triangle() {
        const char* place = at_;
        std::array<int, 3> corners;
        for (int& corner : corners) {
            while (place != end_ && is_blank(*place)) ++place;
            std::uint64_t index = 0;
            const std::ptrdiff_t count = detail::read_digits(place, end_, index);
            if (count == 0 || count > kDigitsThatFit || index - 1 >= mesh_.vertices.size() ||
                place == end_ || !(is_blank(*place) || is_line_end(*place))) {
                return false;
            }
            corner = static_cast<int>(index - 1);
        }
        if (!is_line_end(*place)) return false;
        at_ = place;
        mesh_.corners.insert(mesh_.corners.end(), corners.begin(), corners.end());
        mesh_.ends.push_back(mesh_.corners.size());
        return true;
    }

    void read_vertex() {
        Point point;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            skip_blanks();
            if (at_statement_end()) {
                fail(fmt::format("the vertex ends after {} coordinate{}, expected 3", axis,
                                 axis == 1 ? "" : "s"));
            }
            point[axis] = read_coordinate(kCoordinateNames[axis]);
        }
        // A weight or a colour may follow; anything else is a sign that the line is not a vertex.
        skip_blanks();
        if (!at_statement_end()) mesh_.leave_unused("weights or colours of vertices");
        for (; !at_statement_end(); skip_blanks()) {
            const NumberText number = read_number(at_, end_);
            if (number.kind == NumberText::Kind::none || !at_token_end(number.end)) {
                fail("after the vertex: " + number_complaint(token()));
            }
            at_ = number.end;
        }
        finish_statement();
        mesh_.vertices.push_back(point);
    }

    double read_coordinate(std::string_view name) {
        const NumberText number = read_number(at_, end_);
        if (number.kind != NumberText::Kind::finite || !at_token_end(number.end)) {
            fail(fmt::format("vertex coordinate {}: {}", name, number_complaint(token())));
        }
        at_ = number.end;
        return number.value;
    }

    void read_face() {
        const std::size_t first = mesh_.corners.size();
        const std::int64_t line = line_;
        for (skip_blanks(); !at_statement_end(); skip_blanks())
            mesh_.corners.push_back(read_corner());
        const std::size_t count = mesh_.corners.size() - first;
        if (count < 3 && at_ == end_) {  // without a line end: the rest is missing
            fail(fmt::format("the face ends after {} corner{}, expected at least 3", count,
                             count == 1 ? "" : "s"));
        }
        finish_statement();
        mesh_.finish_face([&] { return fmt::format("line {}", line); });
    }

    /// v, v/vt, v//vn or v/vt/vn; only v is used.
    int read_corner() {
        const char* place = at_;
        std::int64_t index = 0;
        if (!read_integer(place, index)) fail_corner();
        const std::string_view first_part(at_, at(place - at_));
        for (int part = 0; part < 2 && place != end_ && *place == '/'; ++part) {
            ++place;
            std::int64_t unused = 0;
            if (place != end_ && !at_token_end(place) && *place != '/' &&
                !read_integer(place, unused)) {
                fail_corner();
            }
        }
        if (!at_token_end(place)) fail_corner();
        const int vertex = vertex_of(index, first_part);
        at_ = place;
        return vertex;
    }

    /// Counts from 1, or back from the last vertex read so far where negative.
    int vertex_of(std::int64_t index, std::string_view text) {
        const auto known = static_cast<std::int64_t>(mesh_.vertices.size());
        if (index > known) {
            // The first one beyond the end of the list is larger than all before it.
            if (forward_.empty() || index > forward_.back().index) {
                forward_.push_back({index, line_, at_ - line_begin_ + 1, text});
            }
            return static_cast<int>(std::min<std::int64_t>(index, std::numeric_limits<int>::max()) -
                                    1);
        }
        if (index > 0) return static_cast<int>(index - 1);
        if (index == 0) fail("face refers to vertex 0, expected 1 or more (or negative numbers)");
        if (index < -known) {
            fail(fmt::format("face refers to vertex {}, only {} vertices stand before it", text,
                             known));
        }
        return static_cast<int>(known + index);
    }

    bool read_integer(const char*& place, std::int64_t& value) const {
        const char* digits = place;
        const bool negative = digits != end_ && *digits == '-';
        if (negative) ++digits;
        const char* const first = digits;
        while (digits != end_ && *digits == '0') ++digits;
        std::uint64_t size = 0;
        const std::ptrdiff_t count = detail::read_digits(digits, end_, size);
        if (digits == first) return false;
        // Beyond any vertex count.
        constexpr std::int64_t huge = 999'999'999'999'999'999;
        value = count > kDigitsThatFit ? huge : static_cast<std::int64_t>(size);
        if (negative) value = -value;
        place = digits;
        return true;
    }

    void check_complete() const {
        // Then it may be another kind of file.
        if (mesh_.ends.empty() && !unknown_complaint_.empty()) {
            throw InputError(unknown_place_, unknown_complaint_);
        }
        if (mesh_.vertices.empty()) {
            throw InputError({path_}, "has no vertices, expected lines such as 'v 0.1 0.2 0.3'");
        }
        if (mesh_.ends.empty()) {
            throw InputError({path_}, fmt::format("has {} vertices but no faces, expected lines "
                                                  "such as 'f 1 2 3'",
                                                  mesh_.vertices.size()));
        }
        if (mesh_.vertices.size() > at(std::numeric_limits<int>::max())) {
            throw InputError({path_}, fmt::format("has {} vertices, expected at most 2^31 - 1",
                                                  mesh_.vertices.size()));
        }
        for (const ForwardReference& reference : forward_) {
            if (reference.index > static_cast<std::int64_t>(mesh_.vertices.size())) {
                throw InputError({path_, reference.line, reference.column},
                                 fmt::format("face refers to vertex {}, the file has {}",
                                             reference.text, mesh_.vertices.size()));
            }
        }
    }

    [[noreturn]] void fail_corner() const {
        fail(fmt::format("face corner: got {}, expected an index such as 7, 7/2, 7//3, 7/2/3 or -1",
                         in_quotes(token())));
    }

    PolygonMesh mesh_;
    std::vector<ForwardReference> forward_;
    ObjStatements statements_;
    std::string unknown_complaint_;  // about the first one
    FilePosition unknown_place_;
};

}  // namespace

PolygonMesh parse_obj_polygons(std::string_view text, const std::string& path) {
    return ObjReader(text, path).read();
}

}  // namespace mscomp
