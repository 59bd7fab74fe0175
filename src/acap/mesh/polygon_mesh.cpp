// SPDX-License-Identifier: MIT
#include "polygon_mesh.h"

#include <optional>

#include "file_bytes.h"
#include "mesh_format.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

TriangleMesh triangulated(PolygonMesh mesh) {
    TriangleMesh result;
    result.faces = split_into_triangles(mesh);
    result.vertices = std::move(mesh.vertices);
    return result;
}

}  // namespace

PolygonMesh read_polygons(const std::string& path) {
    const std::optional<MeshFormat> format = mesh_format(path);
    if (!format) throw InputError({path}, extension_complaint(path));
    const FileBytes file(path);
    switch (*format) {
        case MeshFormat::obj:
            return parse_obj_polygons(file.bytes(), path);
        case MeshFormat::ply:
            return parse_ply_polygons(file.bytes(), path);
        case MeshFormat::off:
            return parse_off_polygons(file.bytes(), path);
    }
    return {};
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

TriangleMesh parse_off(std::string_view text, const std::string& path) {
    return triangulated(parse_off_polygons(text, path));
}

}  // namespace mscomp
