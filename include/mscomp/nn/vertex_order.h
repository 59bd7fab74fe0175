// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"

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

/// Distances between vertices in inner numbering; rows are copied once each.
class ReorderedDistances final : public DistanceRows {
  public:
    ReorderedDistances(DistanceRows& user_rows, const VertexOrder& order);
    int vertex_count() const override { return order_.vertex_count(); }
    std::span<const double> row(int vertex) override;
    void prepare(std::span<const int> vertices) override;

  private:
    DistanceRows& user_rows_;
    const VertexOrder& order_;
    std::vector<std::vector<double>> rows_;  // (V), empty until asked for
};

}  // namespace mscomp::nn
