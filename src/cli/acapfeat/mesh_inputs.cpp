// SPDX-License-Identifier: MIT
#include "mesh_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/path_from.h"
#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

/// Blanks around a name are no part of it, nor are quotes that a file manager put around it.
std::string_view name_in(std::string_view line, const std::string& folder) {
    const char* const blanks = " \t";
    const std::size_t first = line.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    line = line.substr(first, line.find_last_not_of(blanks) - first + 1);
    const bool is_quoted = line.size() > 2 && line.front() == '"' && line.back() == '"';
    std::error_code error;
    if (is_quoted && !std::filesystem::exists(path_from(folder, std::string(line)), error)) {
        line = line.substr(1, line.size() - 2);
    }
    return line;
}

std::vector<std::string> listed_inputs(const std::string& list) {
    const std::string folder = std::filesystem::path(list).parent_path().string();
    const std::string text = read_text_file(list, "a list of mesh files");
    std::vector<std::string> paths;
    std::string_view rest = text;
    for (std::int64_t number = 1; !rest.empty(); ++number) {
        const std::size_t end = std::min(rest.find_first_of("\r\n"), rest.size());
        const std::string_view name = name_in(rest.substr(0, end), folder);
        rest.remove_prefix(
            std::min(end + (rest.substr(end).starts_with("\r\n") ? 2 : 1), rest.size()));
        if (name.empty() || name.front() == '#') continue;
        paths.push_back(path_from(folder, std::string(name)));
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
