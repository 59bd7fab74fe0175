// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace mscomp {

enum class MeshFormat { obj, ply, off };

/// For messages: the extensions of all formats.
inline constexpr std::string_view kMeshExtensions = ".obj, .ply or .off";

/// The format that the extension of `path` stands for, in any case; none for others.
std::optional<MeshFormat> mesh_format(std::string_view path);

/// "got the extension '.stl', expected ..." for a path that mesh_format does not know.
std::string extension_complaint(std::string_view path);

}  // namespace mscomp
