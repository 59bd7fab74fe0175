// SPDX-License-Identifier: MIT
// The entries of an array of numpy, in whatever order and type they lie there.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/convert/npy.h"
#include "npy_header.h"
#include "utf8.h"

namespace mscomp {
namespace {

static_assert(std::endian::native == std::endian::little, "the arrays are little-endian");

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

}  // namespace mscomp
