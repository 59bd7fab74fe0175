// SPDX-License-Identifier: MIT
#include "mscomp/base/kept_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

/// Of files that these programs read or write, and of meshes of other programs.
constexpr std::array<std::string_view, 20> kKnownExtensions{
    "obj",  "ply", "off", "safetensors", "npz", "npy", "h5",  "hdf5", "txt",  "json",
    "yaml", "yml", "csv", "md",          "png", "svg", "stl", "glb",  "gltf", "fbx"};

bool holds(const std::vector<std::string>& extensions, const std::string& extension) {
    return std::ranges::find(extensions, extension) != extensions.end();
}

}  // namespace

void require_apart(const std::vector<std::string>& outputs,
                   const std::vector<std::string>& inputs) {
    std::map<FileIdentity, std::string> known;
    for (const std::string& input : inputs) {
        if (const auto identity = identity_of(input)) known.emplace(*identity, input);
    }
    for (const std::string& output : outputs) {
        const auto identity = identity_of(output);
        const auto input = identity ? known.find(*identity) : known.end();
        if (input == known.end()) continue;
        throw UsageError(
            input->second == output
                ? fmt::format("{} is an input, wanted another output", output)
                : fmt::format("{} is the input {}, wanted another output", output, input->second));
    }
}

std::vector<std::string> files_of_kind(const std::string& folder,
                                       const std::vector<std::string>& extensions) {
    if (!is_folder(folder)) return {};
    std::vector<std::string> files = files_in(folder);
    std::erase_if(files,
                  [&](const std::string& path) { return !holds(extensions, extension_of(path)); });
    std::ranges::sort(files);
    return files;
}

void require_extension(const std::string& output, const std::string& what,
                       const std::vector<std::string>& extensions) {
    const std::string extension = extension_of(output);
    const bool is_known = std::ranges::find(kKnownExtensions, extension) != kKnownExtensions.end();
    if (!is_known || holds(extensions, extension)) return;
    if (!extensions.empty()) {
        throw UsageError(fmt::format("{} would be {}, wanted a name that ends in .{}", output, what,
                                     fmt::join(extensions, ", .")));
    }
    if (is_folder(output)) return;
    throw UsageError(fmt::format("{} would be {}, wanted a name that does not end in .{}", output,
                                 what, extension));
}

}  // namespace mscomp
