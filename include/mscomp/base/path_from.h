// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// `path` if absolute, otherwise counted from `folder`: how file names in a configuration are
/// meant.
std::string path_from(const std::string& folder, const std::string& path);

}  // namespace mscomp
