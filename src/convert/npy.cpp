// SPDX-License-Identifier: MIT
#include "mscomp/convert/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "npy_header.h"
#include "utf8.h"

namespace mscomp {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kLongestHeader = 1 << 16;
constexpr std::size_t kLongestText = 1 << 20;  // bytes of one entry

struct Number {
    std::string_view descr;  // without its byte order
    NpyType type;
    std::size_t size;
};
constexpr Number kNumbers[] = {
    {"f2", NpyType::f16, 2}, {"f4", NpyType::f32, 4}, {"f8", NpyType::f64, 8},
    {"i1", NpyType::i8, 1},  {"i2", NpyType::i16, 2}, {"i4", NpyType::i32, 4},
    {"i8", NpyType::i64, 8}, {"u1", NpyType::u8, 1},  {"u2", NpyType::u16, 2},
    {"u4", NpyType::u32, 4}, {"u8", NpyType::u64, 8}};

/// "U8" or "S8": sets type and item size; whether it is text at all.
bool read_text_descr(std::string_view descr, NpyArray& array) {
    const bool wide = descr.starts_with('U');
    if (!wide && !descr.starts_with('S')) return false;
    std::size_t length = 0;
    const char* const end = descr.data() + descr.size();
    if (std::from_chars(descr.data() + 1, end, length).ptr != end || length == 0 ||
        length > kLongestText / 4) {
        return false;
    }
    array.type = wide ? NpyType::text : NpyType::bytes;
    array.item_size = wide ? 4 * length : length;
    return true;
}

/// Sets type, item size and byte order. Throws InputError for what is not read.
void read_descr(const std::string& descr, NpyArray& array) {
    if (descr == "|O") {
        throw InputError({array.path},
                         "holds Python objects ('|O'), wanted plain numbers or text; save each "
                         "array by itself, of one type");
    }
    std::string_view rest = descr;
    array.big_endian = rest.starts_with('>');
    if (rest.find_first_of("<>|=") == 0) rest.remove_prefix(1);
    for (const Number& number : kNumbers) {
        if (rest != number.descr) continue;
        array.type = number.type;
        array.item_size = number.size;
        return;
    }
    if (read_text_descr(rest, array)) return;
    throw InputError({array.path},
                     fmt::format("holds entries of type '{}', wanted '<f4', '<f8', '<f2', an "
                                 "integer type such as '<i4', or '<U' with a length",
                                 descr));
}

/// Product of the lengths, if it and the bytes stay below 2^62.
std::optional<std::uint64_t> byte_count(const Shape& shape, std::size_t item_size) {
    constexpr std::uint64_t most = std::uint64_t{1} << 62;
    if (std::find(shape.begin(), shape.end(), 0) != shape.end()) return 0;
    std::uint64_t bytes = item_size;
    for (const std::int64_t length : shape) {
        if (static_cast<std::uint64_t>(length) > most / bytes) return std::nullopt;
        bytes *= static_cast<std::uint64_t>(length);
    }
    return bytes;
}

/// The bytes of the header and, behind it, `data_begin`.
std::string_view header_text(std::string_view bytes, const std::string& path,
                             std::size_t& data_begin) {
    if (!bytes.starts_with(kMagic)) refuse_other_kinds(bytes, path);
    if (!bytes.starts_with(kMagic) || bytes.size() < kMagic.size() + 4) {
        throw InputError({path}, "is not a numpy array: it does not begin with \\x93NUMPY");
    }
    const int major = static_cast<unsigned char>(bytes[6]);
    const int minor = static_cast<unsigned char>(bytes[7]);
    if (major < 1 || major > 3 || minor != 0) {
        throw InputError({path}, fmt::format("is a numpy array of format {}.{}, wanted 1.0, 2.0 or "
                                             "3.0",
                                             major, minor));
    }
    const std::size_t length_size = major == 1 ? 2 : 4;
    std::uint32_t length = 0;
    if (bytes.size() >= 8 + length_size) std::memcpy(&length, bytes.data() + 8, length_size);
    data_begin = 8 + length_size + length;
    if (bytes.size() < data_begin) {
        throw InputError({path}, fmt::format("is truncated: the numpy header ends at byte {}, the "
                                             "array has {}",
                                             data_begin, bytes.size()));
    }
    if (length > kLongestHeader) {
        throw InputError({path}, fmt::format("has a numpy header of {} bytes, wanted at most {}",
                                             length, kLongestHeader));
    }
    return bytes.substr(8 + length_size, length);
}

}  // namespace

NpyArray parse_npy(std::span<const std::byte> bytes, const std::string& path) {
    const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::size_t data_begin = 0;
    const NpyHeader header = parse_npy_header(header_text(all, path, data_begin), path);
    NpyArray array;
    array.path = path;
    array.shape = header.shape;
    read_descr(header.descr, array);
    const std::uint64_t present = bytes.size() - data_begin;
    const std::optional<std::uint64_t> wanted = byte_count(array.shape, array.item_size);
    if (!wanted || *wanted != present) {
        const std::string size = wanted ? fmt::format("{}", *wanted) : "more than 2^62";
        throw InputError({path},
                         fmt::format("{} entries of shape {} take {} bytes, but {} are "
                                     "there",
                                     header.descr, numpy_shape_text(array.shape), size, present));
    }
    array.data = bytes.subspan(data_begin);
    array.strides = strides_of(array.shape, header.fortran_order);
    return array;
}

std::string numpy_type_text(NpyType type, std::size_t item_size) {
    if (type == NpyType::text) return fmt::format("<U{}", item_size / 4);
    if (type == NpyType::bytes) return fmt::format("|S{}", item_size);
    const auto number = std::find_if(std::begin(kNumbers), std::end(kNumbers),
                                     [type](const Number& known) { return known.type == type; });
    return fmt::format("{}{}", item_size == 1 ? '|' : '<', number->descr);
}

std::string npy_header(NpyType type, const Shape& shape, std::size_t item_size) {
    const std::string descr = numpy_type_text(type, item_size);
    std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}",
                                   descr, numpy_shape_text(shape));
    // Data that begin at a multiple of 64 can be mapped and used where they lie.
    constexpr std::size_t before = 10;
    text.append(63 - (before + text.size()) % 64, ' ');
    text += '\n';
    std::string header(kMagic);
    header +=
        {'\x01', '\0', static_cast<char>(text.size() & 0xFF), static_cast<char>(text.size() >> 8)};
    return header + text;
}

std::string npy_texts(const std::vector<std::string>& texts, bool scalar) {
    std::vector<std::u32string> entries;
    std::size_t longest = 1;
    for (const std::string& text : texts) {
        entries.push_back(from_utf8(text));
        longest = std::max(longest, entries.back().size());
    }
    const Shape shape = scalar ? Shape{} : Shape{static_cast<std::int64_t>(texts.size())};
    std::string bytes = npy_header(NpyType::text, shape, 4 * longest);
    for (std::u32string& entry : entries) {
        entry.resize(longest, U'\0');
        bytes.append(reinterpret_cast<const char*>(entry.data()), 4 * longest);
    }
    return bytes;
}

std::string numpy_shape_text(const Shape& shape) {
    std::string text;
    for (const std::int64_t length : shape) {
        text += fmt::format("{}{}", text.empty() ? "" : ", ", length);
    }
    return fmt::format("({}{})", text, shape.size() == 1 ? "," : "");
}

}  // namespace mscomp
