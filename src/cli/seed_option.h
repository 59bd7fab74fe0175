// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <charconv>
#include <cstdint>
#include <string>

namespace mscomp {

/// Check of a `--seed`: empty, or what is wrong with it. The parser would take -1 for 2^64 - 1.
inline std::string is_seed(const std::string& text) {
    std::uint64_t seed = 0;
    const char* end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, seed);
    if (error == std::errc{} && at == end) return "";
    return fmt::format("got {}, wanted a whole number from 0 to 2^64 - 1", text);
}

}  // namespace mscomp
