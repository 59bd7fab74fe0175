// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

enum class PlyFormat { ascii, little_endian, big_endian };
enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };
std::size_t size_of(PlyType type);
bool is_integer(PlyType type);
/// Whether two words differ at most in case, which some programs write as they like.
bool same_word(std::string_view a, std::string_view b);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::f32;
    std::optional<PlyType> count_type;  // set for lists
};

struct PlyElement {
    std::string name;
    std::int64_t count = 0;
    std::int64_t line = 0;  // of its declaration
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::size_t data_begin = 0;  // bytes from the start of the file
    std::int64_t data_line = 0;  // number of the first line of the data
};

/// Reads everything up to and including end_header. Makes sure that the elements it counts can fit
/// the rest of the file. Throws InputError with line, got and expected.
PlyHeader parse_ply_header(std::string_view bytes, const std::string& path);

}  // namespace mscomp
