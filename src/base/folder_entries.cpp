// SPDX-License-Identifier: MIT
#include "folder_entries.h"

#include <dirent.h>

#include <cerrno>
#include <memory>

namespace mscomp {

std::optional<std::vector<std::string>> names_in(const std::string& folder) {
    const auto close = [](DIR* open) { ::closedir(open); };
    const std::unique_ptr<DIR, decltype(close)> entries(::opendir(folder.c_str()), close);
    if (!entries) return std::nullopt;
    std::vector<std::string> names;
    errno = 0;
    while (const dirent* entry = ::readdir(entries.get())) {
        const std::string name = entry->d_name;
        if (name != "." && name != "..") names.push_back(name);
        errno = 0;
    }
    if (errno != 0) return std::nullopt;
    return names;
}

}  // namespace mscomp
