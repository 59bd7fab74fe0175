// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// A mesh as its file has it, before polygons are split: V positions and F polygons of at least
/// three corners, each a valid vertex counting from 0.
struct PolygonMesh {
    std::vector<Point> vertices;
    std::vector<int> corners;       // of all polygons, one after the other
    std::vector<std::size_t> ends;  // (F) one past the last corner of each polygon

    std::size_t face_count() const { return ends.size(); }
    std::span<const int> face(std::size_t index) const {
        const std::size_t begin = index == 0 ? 0 : ends[index - 1];
        return std::span<const int>(corners).subspan(begin, ends[index] - begin);
    }
};

PolygonMesh parse_obj_polygons(std::string_view text, const std::string& path);
PolygonMesh parse_ply_polygons(std::string_view bytes, const std::string& path);
PolygonMesh parse_off_polygons(std::string_view text, const std::string& path);
/// Chosen by the extension. Throws IoError or InputError.
PolygonMesh read_polygons(const std::string& path);

/// Fans from the first corner of every polygon.
std::vector<Face> split_into_triangles(const PolygonMesh& mesh);

}  // namespace mscomp
