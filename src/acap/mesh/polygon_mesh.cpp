// SPDX-License-Identifier: MIT
#include "polygon_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

std::string lower_extension(std::string_view path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

TriangleMesh triangulated(PolygonMesh mesh) {
    TriangleMesh result;
    result.faces = split_into_triangles(mesh);
    result.vertices = std::move(mesh.vertices);
    return result;
}

}  // namespace

bool has_mesh_extension(std::string_view path) {
    const std::string extension = lower_extension(path);
    return extension == ".obj" || extension == ".ply";
}

PolygonMesh read_polygons(const std::string& path) {
    const std::string extension = lower_extension(path);
    if (extension == ".obj") return parse_obj_polygons(read_file(path), path);
    if (extension == ".ply") return parse_ply_polygons(read_file(path), path);
    throw InputError({path},
                     fmt::format("got the extension '{}', expected .obj or .ply", extension));
}

std::vector<Face> split_into_triangles(const PolygonMesh& mesh) {
    std::vector<Face> faces;
    faces.reserve(mesh.corners.size() - 2 * mesh.face_count());
    std::size_t begin = 0;
    for (const std::size_t end : mesh.ends) {
        for (std::size_t corner = begin + 2; corner < end; ++corner) {
            faces.push_back({mesh.corners[begin], mesh.corners[corner - 1], mesh.corners[corner]});
        }
        begin = end;
    }
    return faces;
}

TriangleMesh read_mesh(const std::string& path) { return triangulated(read_polygons(path)); }

TriangleMesh parse_obj(std::string_view text, const std::string& path) {
    return triangulated(parse_obj_polygons(text, path));
}

TriangleMesh parse_ply(std::string_view bytes, const std::string& path) {
    return triangulated(parse_ply_polygons(bytes, path));
}

}  // namespace mscomp
