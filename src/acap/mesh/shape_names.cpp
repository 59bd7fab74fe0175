// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "mscomp/acap/mesh/mesh_sequence.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using Folders = std::vector<std::string>;

Folders folders_of(const std::string& path) {
    Folders folders;
    for (const fs::path& part : fs::path(path).lexically_normal().parent_path()) {
        if (part != "." && part != ".." && part != "/") folders.push_back(part.string());
    }
    return folders;
}

/// How many folders all have in common at their beginning.
std::size_t common_beginning(const std::vector<Folders>& all) {
    const Folders& first = all.front();
    std::size_t common = first.size();
    for (const Folders& folders : all) {
        std::size_t equal = 0;
        while (equal < std::min(common, folders.size()) && folders[equal] == first[equal]) ++equal;
        common = equal;
    }
    return common;
}

/// The folders that tell paths apart, joined and with "_" behind them.
std::vector<std::string> distinguishing_folders(const std::vector<std::string>& paths) {
    std::vector<Folders> all;
    for (const std::string& path : paths) all.push_back(folders_of(path));
    const auto drop_common = [&] {
        const auto common = static_cast<std::ptrdiff_t>(common_beginning(all));
        for (Folders& folders : all) {
            folders.erase(folders.begin(), folders.begin() + common);
            std::reverse(folders.begin(), folders.end());
        }
    };
    drop_common();
    drop_common();  // and at their end
    std::vector<std::string> prefixes;
    for (const Folders& folders : all) {
        std::string& prefix = prefixes.emplace_back();
        for (const std::string& folder : folders) prefix += folder + "_";
    }
    return prefixes;
}

}  // namespace

std::vector<std::string> shape_names(const std::vector<std::string>& paths) {
    std::vector<std::string> stems;
    for (const std::string& path : paths) stems.push_back(fs::path(path).stem().string());
    if (std::set<std::string>(stems.begin(), stems.end()).size() != stems.size()) {
        const std::vector<std::string> folders = distinguishing_folders(paths);
        for (std::size_t i = 0; i < stems.size(); ++i) stems[i] = folders[i] + stems[i];
    }
    std::vector<std::string> names;
    std::set<std::string> taken;
    for (const std::string& stem : stems) {
        std::string name = stem;
        for (int copy = 2; !taken.insert(name).second; ++copy)
            name = fmt::format("{}-{}", stem, copy);
        names.push_back(name);
    }
    return names;
}

}  // namespace mscomp
