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
#include "number_text.h"
#include "ply_header.h"

namespace mscomp {

/// Rows of an ascii PLY: one line each, as the format asks for. Blank lines are skipped.
class PlyTextRows {
  public:
    PlyTextRows(std::string_view bytes, const PlyHeader& header, const std::string& path)
        : at_(bytes.data() + header.data_begin),
          end_(bytes.data() + bytes.size()),
          line_begin_(at_),
          line_(header.data_line),
          path_(path) {}

    void begin_row(const PlyElement& element, std::int64_t index) {
        skip_blank_lines();
        if (at_ == end_) {
            fail(fmt::format("the file ends after {} of {} elements '{}'", index, element.count,
                             element.name));
        }
    }

    double value(PlyType type, std::string_view what) {
        skip_blanks();
        if (at_line_end()) fail(fmt::format("the line ends before {}", what));
        const NumberText number = read_number(at_, end_);
        if (number.kind == NumberText::Kind::none || number.kind == NumberText::Kind::too_large ||
            !at_token_end(number.end)) {
            fail(fmt::format("{}: {}", what, number_complaint(token())));
        }
        if (is_integer(type) && std::floor(number.value) != number.value) {
            fail(fmt::format("{}: got {}, expected a whole number", what, quoted(token())));
        }
        at_ = number.end;
        return number.value;
    }

    void end_row() {
        skip_blanks();
        if (!at_line_end()) {
            fail(fmt::format("got {} after the last property, expected the end of the line",
                             quoted(token())));
        }
    }

    void end_file() {
        skip_blank_lines();
        if (at_ != end_) {
            fail(fmt::format("got {} after the last element, expected the end of the file",
                             quoted(token())));
        }
    }

    std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }
    [[noreturn]] void fail(std::string_view message) const {
        throw InputError({path_, line_, at_ - line_begin_ + 1}, message);
    }

  private:
    bool at_line_end() const { return at_ == end_ || *at_ == '\n' || *at_ == '\r'; }
    bool at_token_end(const char* at) const {
        return at == end_ || *at == ' ' || *at == '\t' || *at == '\n' || *at == '\r';
    }
    std::string_view token() const {
        const char* after = at_;
        while (!at_token_end(after)) ++after;
        return {at_, static_cast<std::size_t>(after - at_)};
    }
    void skip_blanks() {
        while (at_ != end_ && (*at_ == ' ' || *at_ == '\t')) ++at_;
    }
    void skip_blank_lines() {
        for (skip_blanks(); at_ != end_ && at_line_end(); skip_blanks()) {
            at_ += *at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n' ? 2 : 1;
            ++line_;
            line_begin_ = at_;
        }
    }

    const char* at_;
    const char* end_;
    const char* line_begin_;
    std::int64_t line_;
    const std::string& path_;
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
    [[noreturn]] void fail(std::string_view message) const {
        throw InputError({path_}, fmt::format("{} {} of {} (byte {}): {}", element_->name,
                                              index_ + 1, element_->count, at_ + 1, message));
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
    const std::string& path_;
    const PlyElement* element_ = nullptr;
    std::int64_t index_ = 0;
};

}  // namespace mscomp
