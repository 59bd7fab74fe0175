// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Something in a file that no mesh has, passed over by its reader.
struct PassedOver {
    enum class Kind { small_face, unknown_statement };
    Kind kind = Kind::small_face;
    std::int64_t count = 0;
    std::string first;  // its place: "line 7"
};

/// A mesh as its file has it, before polygons are split: V positions and F polygons of at least
/// three corners, each a valid vertex counting from 0.
struct PolygonMesh {
    std::vector<Point> vertices;
    std::vector<int> corners;              // of all polygons, one after the other
    std::vector<std::size_t> ends;         // (F) one past the last corner of each polygon
    std::vector<std::size_t> small_faces;  // of each left-out face: polygons before it; ascending
    std::vector<PassedOver> passed_over;   // each kind at most once
    std::vector<std::string> unused;       // what else the file has: "normals"

    std::size_t face_count() const { return ends.size(); }
    std::span<const int> face(std::size_t index) const {
        const std::size_t begin = index == 0 ? 0 : ends[index - 1];
        return std::span<const int>(corners).subspan(begin, ends[index] - begin);
    }
    /// Which face of its file, from 1, a polygon is: faces of fewer corners count as well.
    std::size_t file_number(std::size_t index) const;

    /// Ends the polygon whose corners were added last; one of fewer than three corners is left out.
    /// `place` says where it is: "line 7".
    template <class Place>
    void finish_face(Place&& place) {
        const std::size_t begin = ends.empty() ? 0 : ends.back();
        if (corners.size() - begin >= 3) return ends.push_back(corners.size());
        corners.resize(begin);
        small_faces.push_back(ends.size());
        pass_over(PassedOver::Kind::small_face, std::forward<Place>(place));
    }
    template <class Place>
    void pass_over(PassedOver::Kind kind, Place&& place) {
        for (PassedOver& known : passed_over) {
            if (known.kind == kind) return void(++known.count);
        }
        passed_over.push_back({kind, 1, place()});
    }
    /// Adds `what` to `unused`, once.
    void leave_unused(std::string_view what);
};

PolygonMesh parse_obj_polygons(std::string_view text, const std::string& path);
PolygonMesh parse_ply_polygons(std::string_view bytes, const std::string& path);
PolygonMesh parse_off_polygons(std::string_view text, const std::string& path);
/// Chosen by the extension. Throws IoError or InputError.
PolygonMesh read_polygons(const std::string& path);

}  // namespace mscomp
