// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "turn_problem.h"

namespace mscomp {

/// Edges across which a rotation vector jumps by more than π (one part in
/// a million more, so that rounding does not decide about half turns).
struct LargeJumps {
    double largest = 0;       // max |r_i - r_j| over all edges, radians
    int count = 0;            // edges above π
    int inherent = 0;         // of these: above π whatever the two turns are
    int removable = 0;        // of these: not shown to cost energy when brought to π or below
    std::int64_t effort = 0;  // copies of vertices that cuts looked at, vertices and edges tried
};

/// Finds the large jumps of `turns`, and tries to remove those that are not inherent: each choice
/// of the two turns that brings the edge to π or below is held, and TurnCover gives a bound for the
/// rest. Where the bound is not above the present energy and turns of no more energy are found,
/// they replace `turns`, if fewer large jumps remain. Edges that are left when the work limit is
/// reached, 500000 and 20 per vertex of `effort`, count as removable.
LargeJumps settle_jumps(const TurnProblem& problem, TurnProblem::Turns& turns);

}  // namespace mscomp
