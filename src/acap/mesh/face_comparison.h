// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "polygon_mesh.h"

namespace mscomp {

/// Where the smallest of all rotations of a face's corners starts.
std::size_t smallest_rotation(std::span<const int> face);

/// The faces of a mesh, sorted, each from the corner that makes it smallest: the same for meshes
/// that differ by the order of their faces and by the corners they start from. Linear in the number
/// of corners for a mesh whose vertices have few faces.
class SortedFaces {
  public:
    explicit SortedFaces(const PolygonMesh& mesh);

    /// The first face, in the order of its file, that `other` does not have, or not as often.
    std::optional<std::size_t> first_missing_in(const SortedFaces& other) const;

  private:
    std::span<const int> face(std::size_t index) const {
        const std::size_t begin = index == 0 ? 0 : ends_[index - 1];
        return std::span<const int>(corners_).subspan(begin, ends_[index] - begin);
    }
    void sort_by_first_corner(std::size_t vertex_count);
    void sort_faces_of_one_corner();

    std::vector<int> corners_;        // of the faces in the order of the file
    std::vector<std::size_t> ends_;   // one past the last corner of each
    std::vector<std::size_t> order_;  // the sorted faces; equal ones in the order of the file
};

}  // namespace mscomp
