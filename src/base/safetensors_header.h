// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mscomp/base/safetensors.h"

namespace mscomp {

// Metadata: XXH3-64 of the data, and of the header without this second entry.
inline constexpr const char* kHashKey = "xxh3";
inline constexpr const char* kHeaderHashKey = "xxh3_header";

/// As 16 hex digits.
std::string hash_text(std::uint64_t hash);
std::string hash_of(std::span<const std::byte> bytes);

/// What stands before the data of a safetensors file.
struct SafetensorsHeader {
    struct Tensor {
        DataType type;
        Shape shape;
        std::uint64_t begin, end;  // bytes from data_begin
    };
    Metadata metadata;
    std::map<std::string, Tensor> tensors;
    std::size_t data_begin = 0;
};

/// "F32", "F64", "I32", "I64", "U8", "U64".
std::string_view name_of(DataType type);
/// "N, 3" with -1 shown as "any".
std::string shape_text(const Shape& shape);
/// Product of the shape times the item size; none if a length is negative or the product too large.
std::optional<std::uint64_t> byte_count(DataType type, const Shape& shape);

/// Length, JSON (with its own hash added) and padding, a multiple of 8 bytes and at least `size`.
std::string header_text(const SafetensorsHeader& header, std::size_t size = 0);
/// Reads and checks the header of the whole file `bytes`: the tensors lie within the data, fill it
/// without hole or overlap, their sizes are those of their shapes, and the header's hash is right
/// where there is one. Throws InputError.
SafetensorsHeader parse_header(std::span<const std::byte> bytes, const std::string& path);

}  // namespace mscomp
