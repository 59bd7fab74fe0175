// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "text_cursor.h"

namespace mscomp {

/// A place in the text of an OBJ that moves forward, knowing its line and column. A statement is a
/// line with its continuation lines: a backslash at the end of a line goes on with the next.
class ObjCursor {
  protected:
    ObjCursor(std::string_view whole, const std::string& path) : path_(path) {
        const std::size_t begin = text_begin(whole, path, "an OBJ mesh");
        const std::string_view text = without_padding(whole.substr(begin));
        at_ = line_begin_ = text.data();
        end_ = text.data() + text.size();
    }

    static bool is_blank(char c) { return c == ' ' || c == '\t'; }
    static bool is_line_end(char c) { return c == '\n' || c == '\r'; }

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

    const char* at_ = nullptr;
    const char* end_ = nullptr;
    const char* line_begin_ = nullptr;
    std::int64_t line_ = 1;
    const std::string& path_;
};

}  // namespace mscomp
