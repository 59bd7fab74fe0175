// SPDX-License-Identifier: MIT
#pragma once

#include <span>

namespace mscomp {

/// Normalised distances over a mesh, a row at a time: what `nn` knows of geodesics.
class DistanceRows {
  public:
    DistanceRows() = default;
    DistanceRows(const DistanceRows&) = delete;
    DistanceRows& operator=(const DistanceRows&) = delete;
    virtual ~DistanceRows() = default;

    virtual int vertex_count() const = 0;
    /// (V) distances from `vertex`, in [0, 1] where 1 is the largest pairwise distance; another
    /// connected component is at distance 1. The span stays valid until the next call of prepare();
    /// asking for further rows does not end it. The same bits whenever it is asked for.
    virtual std::span<const double> row(int vertex) = 0;
    /// Says which rows come next, so that they are computed together and kept until the next call.
    /// All spans handed out before end here, those of `vertices` too. Changes no result.
    virtual void prepare(std::span<const int> vertices) { static_cast<void>(vertices); }
};

}  // namespace mscomp
