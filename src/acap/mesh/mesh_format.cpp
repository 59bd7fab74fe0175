// SPDX-License-Identifier: MIT
#include "mesh_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace mscomp {
namespace {

std::string lower_extension(std::string_view path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

}  // namespace

std::optional<MeshFormat> mesh_format(std::string_view path) {
    const std::string extension = lower_extension(path);
    if (extension == ".obj") return MeshFormat::obj;
    if (extension == ".ply") return MeshFormat::ply;
    if (extension == ".off") return MeshFormat::off;
    return std::nullopt;
}

std::string extension_complaint(std::string_view path) {
    return fmt::format("got the extension '{}', expected {}", lower_extension(path),
                       kMeshExtensions);
}

}  // namespace mscomp
