// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/safetensors.h"

namespace mscomp {

enum class NpyType { f16, f32, f64, i8, i16, i32, i64, u8, u16, u32, u64, text, bytes };
/// "<f4": as numpy writes it, little-endian.
std::string numpy_type_text(NpyType type, std::size_t item_size);

/// One array of numpy: where its numbers lie in the file that was parsed, which has to outlive it.
struct NpyArray {
    std::string path;  // for messages
    NpyType type = NpyType::f32;
    std::size_t item_size = 4;  // bytes; of text four per character
    bool big_endian = false;
    Shape shape;
    Shape strides;  // entries from one to the next along each axis
    std::span<const std::byte> data;

    std::int64_t count() const;
    bool holds_reals() const { return type <= NpyType::f64; }
    bool holds_integers() const { return NpyType::f64 < type && type < NpyType::text; }
    /// Entries [first, first + count) of the first axis in C order, whatever the order in the file.
    /// Integers are taken as they are, to the 53 bits of a double. Throws InputError if the array
    /// holds text, or a number that is not finite (says where; `may_be_nan` lets NaN pass), for
    /// floats also one beyond their range.
    std::vector<double> doubles(std::int64_t first, std::int64_t count,
                                bool may_be_nan = false) const;
    std::vector<float> floats(std::int64_t first, std::int64_t count) const;
    /// All entries. Throws InputError unless it holds integers that fit 32 bits (floating-point
    /// numbers do if all are whole) or text.
    std::vector<int> integers() const;
    std::vector<std::string> texts() const;  // UTF-8
};

/// Reads format 1.0, 2.0 and 3.0 with entries f2, f4, f8, i1 ... i8, u1 ... u8, U or S of either
/// byte order; the header's dictionary is parsed, never evaluated, and the data have to end where
/// the file ends. `path` is only used in messages. Throws InputError.
NpyArray parse_npy(std::span<const std::byte> bytes, const std::string& path);

/// Magic, version 1.0 and header, padded to a multiple of 64 bytes; the data follow in C order.
std::string npy_header(NpyType type, const Shape& shape, std::size_t item_size);

/// A whole array of text of shape (texts.size()), or of no axis if `scalar`, entries padded to the
/// longest; what is not UTF-8 becomes U+FFFD.
std::string npy_texts(const std::vector<std::string>& texts, bool scalar = false);

/// "(2, 3)".
std::string numpy_shape_text(const Shape& shape);

}  // namespace mscomp
