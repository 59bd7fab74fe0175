// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <unordered_map>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/nn/config.h"

namespace mscomp::nn {

/// Where group sparsity acts around a centre: Lambda_ik of [A] eq. 3, 0 nearer than the reach of
/// the centre and 1 from it on, or the clipped ramp of the AAAI-18 predecessor.
struct SparsityRow {
    std::span<const double> distances;  // (V) from the centre
    double from = 0, to = 0;            // weights rise from 0 at `from` to 1 at `to`

    double weight(int vertex) const;
    /// Whether the component may act here at all without full penalty.
    bool is_free(int vertex) const { return weight(vertex) < 1; }
};

/// The rows of one level. The reach of a centre is the sparsity range, or less where more than
/// LevelConfig::max_support of the vertices are nearer than that.
class SparsityRows {
  public:
    /// Borrows `distances`.
    SparsityRows(DistanceRows& distances, const LevelConfig& level);

    SparsityRow row(int center);
    std::vector<SparsityRow> rows(std::span<const int> centers);

  private:
    double reach(std::span<const double> distances) const;

    DistanceRows& distances_;
    LevelConfig level_;
    std::unordered_map<int, double> reaches_;  // by centre
};

}  // namespace mscomp::nn
