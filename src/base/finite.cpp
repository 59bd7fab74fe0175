// SPDX-License-Identifier: MIT
#include "mscomp/base/finite.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>

namespace mscomp {
namespace {

std::string index_text(std::int64_t number, const Shape& shape) {
    std::string text;
    for (std::size_t axis = shape.size(); axis-- > 0;) {
        text = fmt::format("{}{}{}", number % shape[axis], text.empty() ? "" : ", ", text);
        number /= shape[axis];
    }
    return text;
}

template <class T>
bool all_finite(std::span<const std::byte> bytes) {
    // A finite number minus itself is 0, anything else NaN: sums without branches are fast.
    constexpr std::size_t kLanes = 16;
    std::array<T, kLanes> sums{};
    std::size_t at = 0;
    for (; at + sizeof(sums) <= bytes.size(); at += sizeof(sums)) {
        std::array<T, kLanes> values;
        std::memcpy(values.data(), bytes.data() + at, sizeof(values));
        for (std::size_t i = 0; i < kLanes; ++i) sums[i] += values[i] - values[i];
    }
    for (; at < bytes.size(); at += sizeof(T)) {
        T value;
        std::memcpy(&value, bytes.data() + at, sizeof(T));
        sums[0] += value - value;
    }
    for (const T sum : sums) {
        if (!(sum == 0)) return false;
    }
    return true;
}

}  // namespace

template <class T>
std::optional<std::string> first_non_finite(std::span<const std::byte> bytes, std::int64_t first,
                                            const Shape& shape, bool may_be_nan) {
    if (all_finite<T>(bytes)) return std::nullopt;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
        T value;
        std::memcpy(&value, bytes.data() + at, sizeof(T));
        if (std::isfinite(value) || (may_be_nan && std::isnan(value))) continue;
        return fmt::format("[{}] is {}",
                           index_text(first + static_cast<std::int64_t>(at / sizeof(T)), shape),
                           static_cast<double>(value));
    }
    return std::nullopt;
}

std::optional<std::string> first_non_finite(const SafetensorsPiece& piece, bool may_be_nan) {
    switch (piece.type) {
        case DataType::f32:
            return first_non_finite<float>(piece.bytes, piece.first, piece.shape, may_be_nan);
        case DataType::f64:
            return first_non_finite<double>(piece.bytes, piece.first, piece.shape, may_be_nan);
        default:
            return std::nullopt;
    }
}

template std::optional<std::string> first_non_finite<float>(std::span<const std::byte>,
                                                            std::int64_t, const Shape&, bool);
template std::optional<std::string> first_non_finite<double>(std::span<const std::byte>,
                                                             std::int64_t, const Shape&, bool);

}  // namespace mscomp
