// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/row_cache.h"

namespace mscomp::nn {

/// A numbering of the vertices that brings neighbours close together, used inside the network only:
/// files and callers keep the order of the user.
struct VertexOrder {
    std::vector<int> to_user;      // (V) user vertex at each inner place
    std::vector<int> to_internal;  // (V) its inverse

    int vertex_count() const { return static_cast<int>(to_user.size()); }
};

/// Reverse Cuthill-McKee: breadth first from a vertex on the rim of each connected component (the
/// last that a first search reaches), neighbours by rising degree, the whole reversed.
VertexOrder reverse_cuthill_mckee(const OneRings& rings);

OneRings reordered(const OneRings& rings, const VertexOrder& order);

/// Distances between vertices in inner numbering. Rows are copied, and the copies kept up to a
/// limit in bytes beyond those that were prepared last or asked for since: what was used longest
/// ago goes first.
class ReorderedDistances final : public DistanceRows {
  public:
    static constexpr std::size_t kCacheBytes = std::size_t{1} << 30;

    ReorderedDistances(DistanceRows& user_rows, const VertexOrder& order,
                       std::size_t cache_bytes = kCacheBytes);
    int vertex_count() const override { return order_.vertex_count(); }
    std::span<const double> row(int vertex) override;
    void prepare(std::span<const int> vertices) override;
    std::size_t cached_bytes() const { return cache_.bytes(); }

  private:
    std::vector<double> copy_of(std::span<const double> user_row) const;

    DistanceRows& user_rows_;
    const VertexOrder& order_;
    RowCache cache_;  // by inner vertex
};

}  // namespace mscomp::nn
