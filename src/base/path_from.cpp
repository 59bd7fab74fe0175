// SPDX-License-Identifier: MIT
#include "mscomp/base/path_from.h"

#include <filesystem>

namespace mscomp {

std::string path_from(const std::string& folder, const std::string& path) {
    return (std::filesystem::path(folder) / path).string();
}

}  // namespace mscomp
