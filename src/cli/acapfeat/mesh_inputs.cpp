// SPDX-License-Identifier: MIT
#include "mesh_inputs.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>
#include <string_view>

#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/path_from.h"
#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

// Some editors begin UTF-8 with it.
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

std::vector<std::string> listed_inputs(const std::string& list) {
    const std::string folder = std::filesystem::path(list).parent_path().string();
    std::vector<std::string> paths;
    std::istringstream lines(read_file(list));
    std::string line;
    for (std::int64_t number = 1; std::getline(lines, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (number == 1 && line.starts_with(kByteOrderMark)) line.erase(0, kByteOrderMark.size());
        if (line.empty() || line.front() == '#') continue;
        paths.push_back(path_from(folder, line));
        if (!path_exists(paths.back())) {
            throw IoError(paths.back(), fmt::format("no such file, named in {}:{}", list, number));
        }
    }
    if (paths.empty()) throw InputError({list}, "names no file; wanted one mesh file per line");
    return paths;
}

}  // namespace

std::vector<std::string> mesh_paths(const std::vector<std::string>& inputs,
                                    const std::string& list) {
    if (inputs.empty() == list.empty()) {
        throw UsageError("wanted meshes: either INPUT... or --list FILE");
    }
    return list.empty() ? expand_inputs(inputs) : listed_inputs(list);
}

}  // namespace mscomp
