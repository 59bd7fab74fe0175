// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <type_traits>

namespace mscomp {

/// A count, index or enumerator, which is not negative, as the standard containers want it.
template <class Integer>
requires(std::is_integral_v<Integer> || std::is_enum_v<Integer>) constexpr std::size_t
    at(Integer index) {
    return static_cast<std::size_t>(index);
}

}  // namespace mscomp
