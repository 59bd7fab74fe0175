// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Two vertices of two pieces of a mesh.
struct PieceLink {
    int from = 0, to = 0;
};

/// What holds two pieces together: every vertex of the one with fewer vertices is linked to the
/// nearest of the other.
struct PieceJoint {
    int from = 0, to = 0;          // pieces
    std::vector<PieceLink> links;  // from a vertex of `from` to one of `to`
};

/// The joints that make one of all pieces: those that come nearest to each other (a minimum
/// spanning tree), ordered so that `from` is held by piece 0 before. `piece` (V) numbers the pieces
/// from 0; between equal distances the lowest vertices decide.
std::vector<PieceJoint> piece_joints(const std::vector<Point>& points,
                                     const std::vector<int>& piece);

}  // namespace mscomp
