// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

/// Fewest insertions, deletions and replacements of single characters that turn `a` into `b`.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The name with the smallest edit distance, the first one on ties; empty if there are no names.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

}  // namespace mscomp
