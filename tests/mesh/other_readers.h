// SPDX-License-Identifier: MIT
// Meshes as other libraries read them, to compare with ours.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

struct OtherMesh {
    std::vector<Point> vertices;
    std::vector<std::vector<int>> faces;
};

/// By OpenMesh, with double coordinates and polygons; `extension` is such as ".obj".
OtherMesh read_with_openmesh(const std::string& bytes, const std::string& extension);
/// By tinyobjloader, compiled for double, polygons left as they are.
OtherMesh read_with_tinyobjloader(const std::string& text);

/// The same without turning the library's own mesh into ours, for timing: number of faces.
std::size_t parse_with_openmesh(const std::string& bytes, const std::string& extension);
std::size_t parse_with_tinyobjloader(const std::string& text);

}  // namespace mscomp
