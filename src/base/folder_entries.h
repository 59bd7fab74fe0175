// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace mscomp {

/// The names in `folder` but "." and "..", without order; nothing, with errno, if it cannot be
/// read. std::filesystem's iterators end the program where memory runs out.
std::optional<std::vector<std::string>> names_in(const std::string& folder);

}  // namespace mscomp
