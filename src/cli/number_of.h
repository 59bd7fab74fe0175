// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace mscomp {

/// "1 shape" or "7 shapes".
inline std::string number_of(std::int64_t count, std::string_view one, std::string_view many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

inline std::string number_of_shapes(std::int64_t count) {
    return number_of(count, "shape", "shapes");
}
inline std::string number_of_vertices(std::int64_t count) {
    return number_of(count, "vertex", "vertices");
}

}  // namespace mscomp
