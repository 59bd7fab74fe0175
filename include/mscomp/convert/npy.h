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

enum class NpyType { f32, f64, i32, i64, text };

/// One array of numpy: where its numbers lie in the file that was parsed, which has to outlive it.
struct NpyArray {
    std::string path;  // for messages
    NpyType type = NpyType::f32;
    std::size_t item_size = 4;  // bytes; of text four per character
    bool fortran_order = false;
    Shape shape;
    std::span<const std::byte> data;

    std::int64_t count() const;
    /// Entries [first, first + count) of the first axis in C order, whatever the order in the file.
    /// Throws InputError if the array holds something else than floating-point numbers, or one that
    /// is not finite (says where; `may_be_nan` lets NaN pass), for floats also one beyond their
    /// range.
    std::vector<double> doubles(std::int64_t first, std::int64_t count,
                                bool may_be_nan = false) const;
    std::vector<float> floats(std::int64_t first, std::int64_t count) const;
    /// All entries. Throws InputError unless it holds integers (int32) or text.
    std::vector<int> integers() const;
    std::vector<std::string> texts() const;  // UTF-8
};

/// Reads format 1.0, 2.0 and 3.0 with little-endian f4, f8, i4, i8 or U entries; the header's
/// dictionary is parsed, never evaluated, and the data have to end where the file ends.
/// `path` is only used in messages. Throws InputError.
NpyArray parse_npy(std::span<const std::byte> bytes, const std::string& path);

/// Magic, version 1.0 and header, padded to a multiple of 64 bytes; the data follow in C order.
std::string npy_header(NpyType type, const Shape& shape, std::size_t item_size);

/// A whole array of text of shape (texts.size()), or of no axis if `scalar`, entries padded to the
/// longest; what is not UTF-8 becomes U+FFFD.
std::string npy_texts(const std::vector<std::string>& texts, bool scalar = false);

/// "(2, 3)".
std::string numpy_shape_text(const Shape& shape);

}  // namespace mscomp
