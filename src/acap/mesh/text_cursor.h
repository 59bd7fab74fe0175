// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "mscomp/base/file_kind.h"
#include "number_text.h"

namespace mscomp {

/// A place in a text that moves forward, knowing its line and column. Lines end in LF, CR LF or CR;
/// tokens are separated by blanks and tabs and never span lines.
class TextCursor {
  public:
    /// Starts at byte `begin`, which is the start of line `line`. Borrows `text` and `path`.
    TextCursor(std::string_view text, std::size_t begin, std::int64_t line, const std::string& path)
        : at_(text.data() + begin),
          end_(text.data() + text.size()),
          line_begin_(at_),
          line_(line),
          path_(&path) {}

    bool at_end() const { return at_ == end_; }
    bool at_line_end() const { return at_ == end_ || *at_ == '\n' || *at_ == '\r'; }
    bool at(char c) const { return at_ != end_ && *at_ == c; }
    std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }

    void skip_blanks() {
        while (at_ != end_ && (*at_ == ' ' || *at_ == '\t')) ++at_;
    }
    void skip_to_line_end() {
        while (!at_line_end()) ++at_;
    }
    /// To the start of the next line; call it at a line end.
    void next_line() {
        at_ += *at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n' ? 2 : 1;
        ++line_;
        line_begin_ = at_;
    }

    std::int64_t line() const { return line_; }

    /// What stands here, up to a blank or the line end.
    std::string_view token() const {
        const char* after = at_;
        while (!is_token_end(after)) ++after;
        return {at_, static_cast<std::size_t>(after - at_)};
    }
    void skip_token() { at_ += token().size(); }
    /// Over a part of the token here.
    void skip(std::size_t characters) { at_ += characters; }

    /// Takes the number here, NaN and infinities included. Throws InputError, starting with `what`,
    /// if the token is none or is beyond double.
    double take_number(std::string_view what) {
        const NumberText number = read_number(at_, end_);
        if (number.kind == NumberText::Kind::none || number.kind == NumberText::Kind::too_large ||
            !is_token_end(number.end)) {
            fail_token(what);
        }
        taken_ = at_;
        at_ = number.end;
        return number.value;
    }

    /// The text of the number taken last.
    std::string_view taken() const { return {taken_, static_cast<std::size_t>(at_ - taken_)}; }

    /// Throws InputError with the place of the token here, or of the number taken last.
    [[noreturn]] void fail(std::string_view message) const { fail_at(at_, message); }
    [[noreturn]] void fail_taken(std::string_view message) const { fail_at(taken_, message); }
    /// "`what`: got 'x', expected a number".
    [[noreturn]] void fail_token(std::string_view what) const;

  private:
    bool is_token_end(const char* at) const {
        return at == end_ || *at == ' ' || *at == '\t' || *at == '\n' || *at == '\r';
    }
    [[noreturn]] void fail_at(const char* place, std::string_view message) const;

    const char* at_;
    const char* end_;
    const char* line_begin_;
    const char* taken_ = nullptr;
    std::int64_t line_;
    const std::string* path_;
};

/// `text` without what some programs fill their last block with: NUL and 0x1a behind the last line,
/// in any mixture with blanks and line ends.
std::string_view without_padding(std::string_view text);

}  // namespace mscomp
