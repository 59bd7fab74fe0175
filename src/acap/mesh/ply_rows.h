// SPDX-License-Identifier: MIT
// The rows of a PLY file, as text or as bytes, behind one interface.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "mscomp/base/error.h"
#include "ply_header.h"
#include "text_cursor.h"

namespace mscomp {

/// Rows of an ascii PLY: one line each, as the format asks for, or, with `kLinesBreak`, a stream of
/// numbers whose lines break anywhere, as some programs write it. Blank lines are skipped.
template <bool kLinesBreak>
class PlyTextRows {
  public:
    PlyTextRows(std::string_view bytes, const PlyHeader& header, const std::string& path)
        : cursor_(without_padding(bytes), begin_of(bytes, header), header.data_line, path) {}

    void begin_row(const PlyElement& element, std::int64_t index) {
        skip_blank_lines();
        if (cursor_.at_end()) {
            cursor_.fail(fmt::format("the file ends after {} of {} elements '{}'", index,
                                     element.count, element.name));
        }
    }

    double value(PlyType type, std::string_view what) {
        skip_to_value();
        if (cursor_.at_line_end()) cursor_.fail(fmt::format("the line ends before {}", what));
        const double number = cursor_.take_number(what);
        if (is_integer(type) && std::floor(number) != number) {
            fail(fmt::format("{}: got {}, expected a whole number", what,
                             in_quotes(cursor_.taken())));
        }
        return number;
    }

    void end_row() {
        if (kLinesBreak) return;
        cursor_.skip_blanks();
        if (!cursor_.at_line_end()) {
            cursor_.fail(fmt::format("got {} after the last property, expected the end of the line",
                                     in_quotes(cursor_.token())));
        }
    }

    void end_file() {
        skip_blank_lines();
        if (!cursor_.at_end()) {
            cursor_.fail(fmt::format("got {} after the last element, expected the end of the file",
                                     in_quotes(cursor_.token())));
        }
    }

    std::size_t bytes_left() const { return cursor_.bytes_left(); }
    std::string place() const { return fmt::format("line {}", cursor_.line()); }
    /// With the place of the last value.
    [[noreturn]] void fail(std::string_view message) const { cursor_.fail_taken(message); }

  private:
    /// There may be nothing but padding behind the header.
    static std::size_t begin_of(std::string_view bytes, const PlyHeader& header) {
        return std::min(header.data_begin, without_padding(bytes).size());
    }
    void skip_to_value() {
        if (kLinesBreak) {
            skip_blank_lines();
        } else {
            cursor_.skip_blanks();
        }
    }
    void skip_blank_lines() {
        for (cursor_.skip_blanks(); !cursor_.at_end() && cursor_.at_line_end();
             cursor_.skip_blanks()) {
            cursor_.next_line();
        }
    }

    TextCursor cursor_;
};

/// Rows of a binary PLY of either byte order; positions in messages are bytes from the file's
/// start.
template <bool kSwapBytes>
class PlyByteRows {
  public:
    PlyByteRows(std::string_view bytes, const PlyHeader& header, const std::string& path)
        : bytes_(bytes), at_(header.data_begin), path_(path) {}

    void begin_row(const PlyElement& element, std::int64_t index) {
        element_ = &element;
        index_ = index;
    }

    double value(PlyType type, std::string_view what) {
        taken_ = at_;
        if (bytes_left() < size_of(type)) {
            fail(fmt::format("the file ends before {}; it may be truncated", what));
        }
        switch (type) {
            case PlyType::i8:
                return take<std::int8_t>();
            case PlyType::u8:
                return take<std::uint8_t>();
            case PlyType::i16:
                return take<std::int16_t>();
            case PlyType::u16:
                return take<std::uint16_t>();
            case PlyType::i32:
                return take<std::int32_t>();
            case PlyType::u32:
                return take<std::uint32_t>();
            case PlyType::f32:
                return static_cast<double>(take<float>());
            case PlyType::f64:
                return take<double>();
        }
        return 0;
    }

    void end_row() {}

    void end_file() {
        // A closing line end is harmless; more means that the header counts too few elements.
        const std::string_view rest = bytes_.substr(at_);
        if (rest.find_first_not_of("\r\n") != std::string_view::npos) {
            throw InputError({path_}, fmt::format("got {} bytes after the last element, expected "
                                                  "the end of the file",
                                                  rest.size()));
        }
    }

    std::size_t bytes_left() const { return bytes_.size() - at_; }
    std::string place() const { return fmt::format("{} {}", element_->name, index_ + 1); }
    /// With the place of the last value.
    [[noreturn]] void fail(std::string_view message) const {
        throw InputError({path_}, fmt::format("{} {} of {} (byte {}): {}", element_->name,
                                              index_ + 1, element_->count, taken_ + 1, message));
    }

  private:
    template <class T>
    T take() {
        std::array<char, sizeof(T)> raw;
        std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
        if constexpr (kSwapBytes) std::reverse(raw.begin(), raw.end());
        at_ += sizeof(T);
        return std::bit_cast<T>(raw);
    }

    std::string_view bytes_;
    std::size_t at_;
    std::size_t taken_ = 0;  // where the last value started
    const std::string& path_;
    const PlyElement* element_ = nullptr;
    std::int64_t index_ = 0;
};

}  // namespace mscomp
