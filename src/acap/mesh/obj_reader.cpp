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
#include "polygon_mesh.h"
#include "text_cursor.h"

namespace mscomp {
namespace {

/// They change no vertex and no face; curves and surfaces lie beside the mesh. Not among them:
/// "call" and "csh", which would bring in other files.
constexpr std::array<std::string_view, 35> kSkippedKeywords{
    "vt",   "vn",   "vp",     "g",      "o",     "s",     "usemtl",     "mtllib",    "l",
    "p",    "mg",   "usemap", "maplib", "lod",   "bevel", "shadow_obj", "trace_obj", "cstype",
    "deg",  "bmat", "step",   "curv",   "curv2", "surf",  "parm",       "trim",      "hole",
    "scrv", "sp",   "end",    "con",    "ctech", "stech", "c_interp",   "d_interp"};
constexpr std::ptrdiff_t kDigitsThatFit = 18;  // a signed number of 64 bits holds any of them
constexpr std::array<std::string_view, 3> kCoordinateNames{"x", "y", "z"};

bool is_blank(char c) { return c == ' ' || c == '\t'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// One pass over the text. A statement is a line with its continuation lines.
class ObjReader {
  public:
    ObjReader(std::string_view text, const std::string& path)
        : at_(text.data()), end_(text.data() + text.size()), path_(path) {
        at_ += text_begin(text, path, "an OBJ mesh");
        line_begin_ = at_;
        // About what a triangle mesh needs: 30 bytes a vertex, 18 a face, two faces a vertex.
        mesh_.vertices.reserve(text.size() / 64);
        mesh_.ends.reserve(text.size() / 32);
        mesh_.corners.reserve(text.size() / 11);
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
        } else {
            skip_known_statement();
        }
    }

    void skip_known_statement() {
        const std::string_view keyword = token();
        const auto known = std::find(kSkippedKeywords.begin(), kSkippedKeywords.end(), keyword);
        if (known == kSkippedKeywords.end()) {
            fail(
                fmt::format("got the keyword {}, expected v, f, vt, vn, g, o, s, usemtl or another "
                            "one of OBJ",
                            in_quotes(keyword)));
        }
        skip_statement();
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
        for (skip_blanks(); !at_statement_end(); skip_blanks()) {
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
        for (skip_blanks(); !at_statement_end(); skip_blanks())
            mesh_.corners.push_back(read_corner());
        const std::size_t count = mesh_.corners.size() - first;
        if (count < 3) {
            fail(fmt::format("the face ends after {} corner{}, expected at least 3", count,
                             count == 1 ? "" : "s"));
        }
        finish_statement();
        mesh_.ends.push_back(mesh_.corners.size());
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

    void skip_blanks() {
        while (at_ != end_) {
            if (is_blank(*at_)) {
                ++at_;
            } else if (is_continuation(at_)) {
                ++at_;
                next_line();
            } else {
                return;
            }
        }
    }

    bool is_continuation(const char* place) const {
        return place != end_ && *place == '\\' && place + 1 != end_ && is_line_end(place[1]);
    }
    bool at_statement_end() const { return at_ == end_ || is_line_end(*at_) || *at_ == '#'; }
    bool at_token_end(const char* place) const {
        return place == end_ || is_blank(*place) || is_line_end(*place) || is_continuation(place);
    }

    std::string_view token() const {
        const char* after = at_;
        while (!at_token_end(after)) ++after;
        return {at_, at(after - at_)};
    }

    void finish_statement() {
        if (at_ != end_ && *at_ == '#') skip_comment();
    }

    /// Without continuation: a comment that happens to end in a backslash must not swallow a
    /// vertex.
    void skip_comment() {
        while (at_ != end_ && !is_line_end(*at_)) ++at_;
    }

    void skip_statement() {
        while (at_ != end_ && !is_line_end(*at_)) {
            const bool continued = is_continuation(at_);
            ++at_;
            if (continued) next_line();
        }
    }

    void next_line() {
        const bool two_characters = *at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n';
        at_ += two_characters ? 2 : 1;
        ++line_;
        line_begin_ = at_;
    }

    FilePosition here() const { return {path_, line_, at_ - line_begin_ + 1}; }
    [[noreturn]] void fail(std::string_view message) const { throw InputError(here(), message); }
    [[noreturn]] void fail_corner() const {
        fail(fmt::format("face corner: got {}, expected an index such as 7, 7/2, 7//3, 7/2/3 or -1",
                         in_quotes(token())));
    }

    const char* at_;
    const char* end_;
    const char* line_begin_ = nullptr;
    std::int64_t line_ = 1;
    const std::string& path_;
    PolygonMesh mesh_;
    std::vector<ForwardReference> forward_;
};

}  // namespace

PolygonMesh parse_obj_polygons(std::string_view text, const std::string& path) {
    return ObjReader(text, path).read();
}

}  // namespace mscomp
