// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/eval/measures.h"

namespace mscomp {

/// E_rms as RmsError has it, but every connected component of the mesh moved to its truth by a
/// rigid motion of its own: what is left of the error if nobody asks where the pieces lie to each
/// other. Never above RmsError's but for rounding, the same on a mesh in one piece.
class PieceRmsError {
  public:
    /// Throws MeshError if there are no vertices.
    explicit PieceRmsError(const TriangleMesh& reference);

    int piece_count() const { return static_cast<int>(pieces_.size()); }
    /// Throws MeshError if the numbers of vertices are not those of the reference.
    void add(const std::vector<Point>& truth, const std::vector<Point>& result);
    /// Of all shapes; NaN before the first.
    double value() const;

  private:
    std::vector<std::vector<int>> pieces_;  // vertices of each
    std::size_t vertex_count_;
    double scale_;
    double squares_ = 0, coordinates_ = 0;
};

}  // namespace mscomp
