// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Features say nothing about where a connected component lies: this moves each to where its
/// centroid belongs.
class Placement {
  public:
    Placement(const OneRings& rings, std::vector<Point> reference);

    int component_count() const { return component_count_; }
    /// (V) numbered from 0 in the order of their lowest vertex.
    const std::vector<int>& component() const { return component_; }
    /// Lowest vertex of every component.
    const std::vector<int>& first_vertices() const { return first_vertices_; }

    /// Moves every component of `positions` (V) so that its centroid is the one it has in `like`
    /// (V), or in the reference if that is empty; components marked in `left_alone` (C, or empty)
    /// stay. Throws MeshError if `like` has another V.
    void apply(std::span<const Point> like, std::vector<Point>& positions,
               const std::vector<char>& left_alone = {}) const;

  private:
    std::vector<Point> centroids(std::span<const Point> positions) const;

    std::vector<int> component_;
    std::vector<int> first_vertices_;
    int component_count_ = 0;
    std::vector<Point> reference_centroids_;
};

}  // namespace mscomp
