// SPDX-License-Identifier: MIT
#include "mscomp/convert/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "npy_header.h"
#include "utf8.h"

namespace mscomp {
namespace {

static_assert(std::endian::native == std::endian::little, "the arrays are little-endian");

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

/// In entries, of an array without gaps.
Shape strides_of(const Shape& shape, bool fortran_order) {
    Shape strides(shape.size(), 1);
    if (std::find(shape.begin(), shape.end(), 0) != shape.end()) return strides;
    if (fortran_order) {
        for (std::size_t i = 1; i < shape.size(); ++i) strides[i] = strides[i - 1] * shape[i - 1];
    } else {
        for (std::size_t i = shape.size(); i-- > 1;) strides[i - 1] = strides[i] * shape[i];
    }
    return strides;
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

template <class T>
T load(const NpyArray& array, std::int64_t index) {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), array.data.data() + at(index) * sizeof(T), sizeof(T));
    if (array.big_endian) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
}

/// IEEE 754 binary16.
double from_half(std::uint16_t bits) {
    const int exponent = (bits >> 10) & 31, fraction = bits & 1023;
    const double sign = (bits & 0x8000) != 0 ? -1 : 1;
    if (exponent == 31) return fraction == 0 ? sign * HUGE_VAL : std::nan("");
    if (exponent == 0) return sign * std::ldexp(fraction, -24);
    return sign * std::ldexp(1024 + fraction, exponent - 25);
}

/// What does not fit becomes the largest that does.
std::int64_t load_integer(const NpyArray& array, std::int64_t place) {
    switch (array.type) {
        case NpyType::i8:
            return load<std::int8_t>(array, place);
        case NpyType::i16:
            return load<std::int16_t>(array, place);
        case NpyType::i32:
            return load<std::int32_t>(array, place);
        case NpyType::i64:
            return load<std::int64_t>(array, place);
        case NpyType::u8:
            return load<std::uint8_t>(array, place);
        case NpyType::u16:
            return load<std::uint16_t>(array, place);
        case NpyType::u32:
            return load<std::uint32_t>(array, place);
        default:
            return static_cast<std::int64_t>(std::min<std::uint64_t>(
                load<std::uint64_t>(array, place), std::numeric_limits<std::int64_t>::max()));
    }
}

double load_real(const NpyArray& array, std::int64_t place) {
    if (array.type == NpyType::f16) return from_half(load<std::uint16_t>(array, place));
    if (array.holds_integers()) return static_cast<double>(load_integer(array, place));
    if (array.type == NpyType::f32) return static_cast<double>(load<float>(array, place));
    return load<double>(array, place);
}

/// Calls use(position in the file, in entries) for entries [first, first + count) of the first
/// axis in C order.
template <class Use>
void for_each_entry(const NpyArray& array, std::int64_t first, std::int64_t count, Use&& use) {
    const std::size_t rank = array.shape.size();
    const std::int64_t length = rank == 0 ? 1 : array.shape[0];
    if (first < 0 || count < 0 || first > length - count) {
        throw std::logic_error("NpyArray: rows beyond the array");
    }
    const std::int64_t row = length == 0 ? 0 : array.count() / length;
    if (row == 0) return;  // then the other lengths may be too large to multiply
    if (array.strides == strides_of(array.shape, false)) {
        for (std::int64_t i = first * row; i < (first + count) * row; ++i) use(i);
        return;
    }
    Shape index(rank, 0);
    std::int64_t place = first * array.strides[0];
    for (std::int64_t left = count * row; left > 0; --left) {
        use(place);
        for (std::size_t axis = rank; axis-- > 0;) {
            place += array.strides[axis];
            if (++index[axis] < array.shape[axis] || axis == 0) break;
            place -= array.strides[axis] * array.shape[axis];
            index[axis] = 0;
        }
    }
}

/// "[2, 17, 0] is nan" for the entry that comes `number`-th from row `first` on.
std::string place_text(const NpyArray& array, std::int64_t first, std::size_t number,
                       double value) {
    auto rest = static_cast<std::int64_t>(number);
    std::string index;
    for (std::size_t axis = array.shape.size(); axis-- > 0;) {
        const std::int64_t here = axis == 0 ? first + rest : rest % array.shape[axis];
        index = fmt::format("{}{}{}", here, index.empty() ? "" : ", ", index);
        rest /= array.shape[axis];
    }
    return fmt::format("[{}] is {}", index, value);
}

template <class T>
std::vector<T> read_reals(const NpyArray& array, std::int64_t first, std::int64_t count,
                          bool may_be_nan) {
    if (!array.holds_reals() && !array.holds_integers()) {
        throw InputError({array.path}, "holds no numbers, wanted '<f4' or '<f8'");
    }
    std::vector<T> values;
    const auto append = [&](double value) {
        const T kept = static_cast<T>(value);
        if (!std::isfinite(kept) && !(may_be_nan && std::isnan(kept))) {
            throw InputError({array.path}, place_text(array, first, values.size(), value) +
                                               ", wanted a finite number" +
                                               (std::isfinite(value) ? " of float32" : ""));
        }
        values.push_back(kept);
    };
    if (array.count() > 0 && !array.shape.empty()) {
        values.reserve(at(array.count() / array.shape[0] * count));
    }
    for_each_entry(array, first, count,
                   [&](std::int64_t place) { append(load_real(array, place)); });
    return values;
}

std::int64_t row_count(const NpyArray& array) { return array.shape.empty() ? 1 : array.shape[0]; }

}  // namespace

std::int64_t NpyArray::count() const { return static_cast<std::int64_t>(data.size() / item_size); }

std::vector<double> NpyArray::doubles(std::int64_t first, std::int64_t entries,
                                      bool may_be_nan) const {
    return read_reals<double>(*this, first, entries, may_be_nan);
}

std::vector<float> NpyArray::floats(std::int64_t first, std::int64_t entries) const {
    return read_reals<float>(*this, first, entries, false);
}

std::vector<int> NpyArray::integers() const {
    if (!holds_integers() && !holds_reals()) {
        throw InputError({path}, "holds no integers, wanted '<i4' or '<i8'");
    }
    std::vector<int> values;
    values.reserve(at(count()));
    for_each_entry(*this, 0, row_count(*this), [&](std::int64_t place) {
        std::int64_t value = 0;
        if (holds_integers()) {
            value = load_integer(*this, place);
        } else {
            const double real = load_real(*this, place);
            if (!(std::abs(real) < 1e15) || std::floor(real) != real) {
                throw InputError({path}, fmt::format("holds no integers but {}, wanted '<i4' or "
                                                     "'<i8'",
                                                     real));
            }
            value = static_cast<std::int64_t>(real);
        }
        if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
            throw InputError({path}, fmt::format("holds {}, wanted an integer of 32 bits", value));
        }
        values.push_back(static_cast<int>(value));
    });
    return values;
}

std::vector<std::string> NpyArray::texts() const {
    if (type != NpyType::text && type != NpyType::bytes) {
        throw InputError({path}, "holds no text, wanted '<U' with a length");
    }
    std::vector<std::string> values;
    for_each_entry(*this, 0, row_count(*this), [&](std::int64_t place) {
        std::u32string characters;
        if (type == NpyType::bytes) {
            characters = from_utf8(
                {reinterpret_cast<const char*>(data.data()) + at(place) * item_size, item_size});
        } else {
            const auto length = static_cast<std::int64_t>(item_size / 4);
            for (std::int64_t i = 0; i < length; ++i) {
                characters += load<char32_t>(*this, place * length + i);
            }
        }
        while (!characters.empty() && characters.back() == U'\0') characters.pop_back();
        values.push_back(to_utf8(characters));
    });
    return values;
}

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
