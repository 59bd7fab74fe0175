// SPDX-License-Identifier: MIT
#include "polygon_mesh.h"

#include <algorithm>
#include <optional>

#include "file_bytes.h"
#include "mesh_format.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "polygon_split.h"

namespace mscomp {
namespace {

TriangleMesh triangulated(PolygonMesh mesh) {
    TriangleMesh result;
    result.faces = split_into_triangles(mesh, mesh.vertices).faces;
    result.vertices = std::move(mesh.vertices);
    return result;
}

}  // namespace

PolygonMesh read_polygons(const std::string& path) {
    const std::optional<MeshFormat> format = mesh_format(path);
    const FileBytes file(path);
    if (!format) {
        refuse_other_kinds(file.bytes(), path);
        throw InputError({path}, extension_complaint(path));
    }
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

std::size_t PolygonMesh::file_number(std::size_t index) const {
    const auto behind = std::upper_bound(small_faces.begin(), small_faces.end(), index);
    return index + 1 + at(behind - small_faces.begin());
}

void PolygonMesh::leave_unused(std::string_view what) {
    if (std::find(unused.begin(), unused.end(), what) == unused.end()) unused.emplace_back(what);
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
