// SPDX-License-Identifier: MIT
#include "mscomp/convert/npy.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>

#include "mscomp/base/error.h"
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
    const char* descr;
    NpyType type;
    std::size_t size;
};
constexpr Number kNumbers[] = {{"<f4", NpyType::f32, 4},
                               {"<f8", NpyType::f64, 8},
                               {"<i4", NpyType::i32, 4},
                               {"<i8", NpyType::i64, 8}};

/// Sets type and item size. Throws InputError for what is not read.
void read_descr(const std::string& descr, NpyArray& array) {
    for (const Number& number : kNumbers) {
        if (descr != number.descr) continue;
        array.type = number.type;
        array.item_size = number.size;
        return;
    }
    std::size_t length = 0;
    const char* const end = descr.data() + descr.size();
    if (descr.starts_with("<U") && std::from_chars(descr.data() + 2, end, length).ptr == end &&
        length > 0 && length <= kLongestText / 4) {
        array.type = NpyType::text;
        array.item_size = 4 * length;
        return;
    }
    throw InputError({array.path}, fmt::format("holds entries of type '{}', wanted '<f4', '<f8', "
                                               "'<i4', '<i8' or '<U' with a length",
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
T load(std::span<const std::byte> data, std::int64_t index) {
    T value;
    std::memcpy(&value, data.data() + at(index) * sizeof(T), sizeof(T));
    return value;
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
    if (!array.fortran_order || rank < 2) {
        for (std::int64_t i = first * row; i < (first + count) * row; ++i) use(i);
        return;
    }
    if (row == 0) return;  // then the other lengths may be too large to multiply
    Shape index(rank, 0), strides(rank, 1);
    for (std::size_t axis = 1; axis < rank; ++axis) {
        strides[axis] = strides[axis - 1] * array.shape[axis - 1];
    }
    std::int64_t place = first;
    for (std::int64_t left = count * row; left > 0; --left) {
        use(place);
        for (std::size_t axis = rank; axis-- > 0;) {
            place += strides[axis];
            if (++index[axis] < array.shape[axis] || axis == 0) break;
            place -= strides[axis] * array.shape[axis];
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
    if (array.type != NpyType::f32 && array.type != NpyType::f64) {
        throw InputError({array.path}, "holds no floating-point numbers, wanted '<f4' or '<f8'");
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
    for_each_entry(array, first, count, [&](std::int64_t place) {
        append(array.type == NpyType::f32 ? static_cast<double>(load<float>(array.data, place))
                                          : load<double>(array.data, place));
    });
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
    if (type != NpyType::i32 && type != NpyType::i64) {
        throw InputError({path}, "holds no integers, wanted '<i4' or '<i8'");
    }
    std::vector<int> values;
    values.reserve(at(count()));
    for_each_entry(*this, 0, row_count(*this), [&](std::int64_t place) {
        const std::int64_t value = type == NpyType::i32 ? load<std::int32_t>(data, place)
                                                        : load<std::int64_t>(data, place);
        if (value < std::numeric_limits<int>::min() || value > std::numeric_limits<int>::max()) {
            throw InputError({path}, fmt::format("holds {}, wanted an integer of 32 bits", value));
        }
        values.push_back(static_cast<int>(value));
    });
    return values;
}

std::vector<std::string> NpyArray::texts() const {
    if (type != NpyType::text) throw InputError({path}, "holds no text, wanted '<U' with a length");
    std::vector<std::string> values;
    for_each_entry(*this, 0, row_count(*this), [&](std::int64_t place) {
        std::u32string characters(item_size / 4, U'\0');
        std::memcpy(characters.data(), data.data() + at(place) * item_size, item_size);
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
    array.fortran_order = header.fortran_order;
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
    return array;
}

std::string npy_header(NpyType type, const Shape& shape, std::size_t item_size) {
    std::string descr = fmt::format("<U{}", item_size / 4);
    for (const Number& number : kNumbers) {
        if (type == number.type) descr = number.descr;
    }
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
