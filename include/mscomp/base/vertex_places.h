// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Where on the surface the V vertices of a mesh lie. Vertices that coincide in every shape of a
/// set (the two sides of a UV seam, the corners of a triangle soup) are one place; a vertex that no
/// face uses is none. What is computed on a mesh is computed on its W places, which are a mesh
/// like any other; files keep V vertices in their order.
class VertexPlaces {
  public:
    /// Every vertex is a place of its own, however many there are.
    VertexPlaces() = default;
    /// `coincident` (V): the lowest vertex each coincides with, itself where there is none lower.
    VertexPlaces(const std::vector<int>& coincident, const std::vector<Face>& faces);
    /// From place_of_vertex() as it was stored; empty: every vertex is a place of its own. Throws
    /// MeshError unless places count from 0 in the order of their lowest vertices and no face has
    /// a corner without a place.
    static VertexPlaces from_stored(std::vector<int> place, const std::vector<Face>& faces);

    /// Whether every vertex is a place of its own: then all that follows hands back what it gets.
    bool are_all_vertices() const { return place_.empty(); }
    /// (V) -1: no face uses this vertex. Empty if every vertex is a place of its own.
    const std::vector<int>& place_of_vertex() const { return place_; }
    /// Vertices that share their place with a lower one, and vertices without a place.
    int coincident_count() const;
    int unused_count() const;
    /// W.
    int place_count(int vertex_count) const {
        return place_.empty() ? vertex_count : static_cast<int>(lowest_.size());
    }
    /// The lowest vertex at a place, and the place of a vertex (-1: none).
    int vertex(int place) const { return place_.empty() ? place : lowest_[at(place)]; }
    int place(int vertex) const { return place_.empty() ? vertex : place_[at(vertex)]; }

    /// The mesh of the places: W vertices and all F faces, in their order; a face whose corners
    /// meet has a vertex twice.
    TriangleMesh surface(const TriangleMesh& mesh) const;
    /// The same faces with the lowest vertex of its place at every corner.
    std::vector<Face> joined(std::vector<Face> faces) const;
    /// Rows of `width` numbers of the W places out of those of the V vertices.
    template <class T>
    std::vector<T> of_places(std::span<const T> rows, int width = 1) const;
    /// Overwrites `rows` (V) at every vertex that has a place with what is there (W).
    template <class T>
    void to_vertices(std::span<const T> places, std::span<T> rows, int width = 1) const;

  private:
    std::vector<int> place_;   // (V), empty if trivial
    std::vector<int> lowest_;  // (W), ascending
};

template <class T>
std::vector<T> VertexPlaces::of_places(std::span<const T> rows, int width) const {
    if (are_all_vertices()) return {rows.begin(), rows.end()};
    std::vector<T> result;
    result.reserve(lowest_.size() * at(width));
    for (const int vertex : lowest_) {
        const std::span<const T> row = rows.subspan(at(vertex) * at(width), at(width));
        result.insert(result.end(), row.begin(), row.end());
    }
    return result;
}

template <class T>
void VertexPlaces::to_vertices(std::span<const T> places, std::span<T> rows, int width) const {
    for (std::size_t v = 0; v < rows.size() / at(width); ++v) {
        const int from = place(static_cast<int>(v));
        if (from < 0) continue;
        std::ranges::copy(places.subspan(at(from) * at(width), at(width)),
                          rows.subspan(v * at(width)).begin());
    }
}

}  // namespace mscomp
