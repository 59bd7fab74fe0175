// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Where a reference is pinched and shapes are not, they stretch without a fault of theirs. Told by
/// how far a ring spreads in the direction in which it is second widest: 0 where it is pinched to a
/// line or a point.
class PinchedRings {
  public:
    /// Borrows both.
    PinchedRings(const std::vector<Point>& reference, const OneRings& rings);

    /// Whether the reference is pinched at `vertex` and `shape`, `size_ratio` times as large, is
    /// not wider there than usual.
    bool opens_a_pinch(const std::vector<Point>& shape, int vertex, double size_ratio) const;

  private:
    const std::vector<Point>& reference_;
    const OneRings& rings_;
    double usual_width_;  // median of the rings of the reference
};

}  // namespace mscomp
