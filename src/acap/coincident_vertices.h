// SPDX-License-Identifier: MIT
#pragma once

#include <mutex>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Finds the vertices that lie on each other in every shape of a set, as the two sides of a UV seam
/// do. Vertices that touch in some shapes only (closed lips) are not among them. Lying on each
/// other: no farther apart than a ten-millionth of the size, which is what float32 tells apart.
class CoincidentVertices {
  public:
    /// Those of the reference; vertices that no face uses are never among them.
    explicit CoincidentVertices(const TriangleMesh& reference);

    /// Whether there are any.
    bool any() const;
    /// Only those stay that lie on each other in `shape` (V), too. From any thread, the same result
    /// in any order of the shapes.
    void keep(const std::vector<Point>& shape);
    /// (V) the lowest vertex that each one coincides with, itself if none is lower.
    std::vector<int> lowest() const;

  private:
    /// For every member the index of the first one of its group that it lies on.
    std::vector<int> firsts_in(const std::vector<Point>& shape) const;

    std::size_t vertex_count_;
    std::vector<int> used_;     // vertices in faces: others may lie anywhere
    std::vector<int> members_;  // vertices that lie on another in the reference, group by group
    std::vector<std::size_t> group_ends_;  // one past the last member of each group
    mutable std::mutex mutex_;
    std::vector<int> first_;  // (members) index of the first member each coincides with so far
};

}  // namespace mscomp
