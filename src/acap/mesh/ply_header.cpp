// SPDX-License-Identifier: MIT
#include "ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "number_text.h"
#include "text_cursor.h"

namespace mscomp {
namespace {

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames{
    {{"char", PlyType::i8},
     {"int8", PlyType::i8},
     {"uchar", PlyType::u8},
     {"uint8", PlyType::u8},
     {"short", PlyType::i16},
     {"int16", PlyType::i16},
     {"ushort", PlyType::u16},
     {"uint16", PlyType::u16},
     {"int", PlyType::i32},
     {"int32", PlyType::i32},
     {"uint", PlyType::u32},
     {"uint32", PlyType::u32},
     {"float", PlyType::f32},
     {"float32", PlyType::f32},
     {"double", PlyType::f64},
     {"float64", PlyType::f64}}};

class HeaderReader {
  public:
    HeaderReader(std::string_view bytes, const std::string& path)
        : bytes_(bytes), path_(path), at_(text_begin(bytes, path, "a PLY mesh")) {}

    PlyHeader read() {
        next_line();
        if (words_.size() != 1 || !same_word(words_[0], "ply")) {
            fail(fmt::format("got {}, expected 'ply' as the first line", in_quotes(line_text_)));
        }
        bool has_format = false;
        for (;;) {
            next_line();
            if (words_.empty() || same_word(words_[0], "comment") ||
                same_word(words_[0], "obj_info"))
                continue;
            if (same_word(words_[0], "end_header")) break;
            if (same_word(words_[0], "format")) {
                read_format();
                has_format = true;
            } else if (same_word(words_[0], "element")) {
                read_element();
            } else if (same_word(words_[0], "property")) {
                read_property();
            } else {
                fail(
                    fmt::format("got {}, expected format, element, property, comment, obj_info or "
                                "end_header",
                                in_quotes(words_[0])));
            }
        }
        if (!has_format) fail("the header ends without a 'format' line");
        header_.data_begin = at_;
        header_.data_line = line_ + 1;
        return std::move(header_);
    }

  private:
    /// Lines end as the first one does: after end_header a binary byte may look like a line end.
    void next_line() {
        if (line_end_.empty()) {
            const std::size_t first = bytes_.find_first_of("\r\n");
            if (first == std::string_view::npos) {
                line_end_ = "\n";
            } else {
                line_end_ = bytes_.substr(first, bytes_.substr(first, 2) == "\r\n" ? 2 : 1);
            }
        }
        const std::size_t found = bytes_.find(line_end_, at_);
        if (found == std::string_view::npos && line_ > 0) {
            fail("the file ends within the header, expected 'end_header'");
        }
        line_text_ = bytes_.substr(at_, found == std::string_view::npos ? found : found - at_);
        at_ = found == std::string_view::npos ? bytes_.size() : found + line_end_.size();
        ++line_;
        split_words();
    }

    void split_words() {
        words_.clear();
        for (std::size_t place = 0;;) {
            place = line_text_.find_first_not_of(" \t\r", place);
            if (place == std::string_view::npos) return;
            const std::size_t after =
                std::min(line_text_.find_first_of(" \t\r", place), line_text_.size());
            words_.push_back(line_text_.substr(place, after - place));
            place = after;
        }
    }

    void read_format() {
        constexpr std::array<std::pair<std::string_view, PlyFormat>, 3> formats{
            {{"ascii", PlyFormat::ascii},
             {"binary_little_endian", PlyFormat::little_endian},
             {"binary_big_endian", PlyFormat::big_endian}}};
        for (const auto& [name, format] : formats) {
            if (words_.size() == 3 && same_word(words_[1], name) && words_[2] == "1.0") {
                header_.format = format;
                return;
            }
        }
        fail(
            fmt::format("got {}, expected 'format' with ascii, binary_little_endian or "
                        "binary_big_endian, and 1.0",
                        in_quotes(line_text_)));
    }

    void read_element() {
        PlyElement element;
        const auto parsed = [&](std::string_view text) {
            const char* const end = text.data() + text.size();
            const auto [after, error] = std::from_chars(text.data(), end, element.count);
            return error == std::errc{} && after == end && element.count >= 0;
        };
        if (words_.size() != 3 || !parsed(words_[2])) {
            fail(fmt::format("got {}, expected 'element', a name and a count",
                             in_quotes(line_text_)));
        }
        element.name = words_[1];
        element.line = line_;
        header_.elements.push_back(std::move(element));
    }

    void read_property() {
        if (header_.elements.empty()) fail("got a property, expected an element before it");
        PlyProperty property;
        const bool list = words_.size() == 5 && same_word(words_[1], "list");
        if (list) {
            property.count_type = read_type(words_[2]);
            if (!is_integer(*property.count_type)) {
                fail(fmt::format("got the count type {}, expected an integer type",
                                 in_quotes(words_[2])));
            }
        } else if (words_.size() != 3) {
            fail(
                fmt::format("got {}, expected 'property', a type and a name, or 'property list', "
                            "two types and a name",
                            in_quotes(line_text_)));
        }
        property.type = read_type(words_[words_.size() - 2]);
        property.name = words_.back();
        header_.elements.back().properties.push_back(std::move(property));
    }

    PlyType read_type(std::string_view word) const {
        for (const auto& [name, type] : kTypeNames) {
            if (same_word(word, name)) return type;
        }
        fail(
            fmt::format("got the type {}, expected char, uchar, short, ushort, int, uint, float, "
                        "double or int8 ... float64",
                        in_quotes(word)));
    }

    [[noreturn]] void fail(std::string_view message) const {
        throw InputError({path_, line_}, message);
    }

    std::string_view bytes_;
    const std::string& path_;
    std::string_view line_end_;
    std::string_view line_text_;
    std::vector<std::string_view> words_;
    std::size_t at_;
    std::int64_t line_ = 0;
    PlyHeader header_;
};

/// The fewest bytes one row of `element` can take.
std::uint64_t smallest_row(const PlyElement& element, PlyFormat format) {
    // One digit and what separates it from the next.
    if (format == PlyFormat::ascii) return 2 * element.properties.size();
    std::uint64_t bytes = 0;
    for (const PlyProperty& property : element.properties) {
        bytes += size_of(property.count_type.value_or(property.type));
    }
    return bytes;
}

void check_counts(const PlyHeader& header, std::size_t file_size, const std::string& path) {
    std::uint64_t left = file_size - header.data_begin;
    if (header.format == PlyFormat::ascii) ++left;  // the last line end may be missing
    for (const PlyElement& element : header.elements) {
        const auto count = static_cast<std::uint64_t>(element.count);
        std::uint64_t wanted = 0;
        if (__builtin_mul_overflow(count, smallest_row(element, header.format), &wanted) ||
            wanted > left) {
            throw InputError(
                {path, element.line},
                fmt::format("got {} elements '{}', expected no more than fit the {} "
                            "bytes after the header; the file may be truncated",
                            element.count, element.name, file_size - header.data_begin));
        }
        left -= wanted;
    }
}

}  // namespace

std::size_t size_of(PlyType type) {
    constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[at(type)];
}

bool same_word(std::string_view a, std::string_view b) {
    const auto lower = [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c; };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [&](char x, char y) { return lower(x) == lower(y); });
}

bool is_integer(PlyType type) { return type < PlyType::f32; }

PlyHeader parse_ply_header(std::string_view bytes, const std::string& path) {
    PlyHeader header = HeaderReader(bytes, path).read();
    check_counts(header, bytes.size(), path);
    return header;
}

}  // namespace mscomp
