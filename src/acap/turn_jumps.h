// SPDX-License-Identifier: MIT
#pragma once

#include "turn_problem.h"

namespace mscomp {

/// Edges across which a rotation vector jumps by more than π.
struct LargeJumps {
    double largest = 0;  // max |r_i - r_j| over all edges, radians
    int count = 0;       // edges above π
    int inherent = 0;    // of these: above π whatever the two turns are
    int removable = 0;   // of these: not shown to cost energy when brought to π or below
};

/// Finds the large jumps of `turns`, and tries to remove those that are not inherent: each choice
/// of the two turns that brings the edge to π or below is held, and TurnCover gives a bound for the
/// rest. Where the bound is not above the present energy and turns of no more energy are found,
/// they replace `turns`. Edges that are left when the work limit is reached count as removable.
LargeJumps settle_jumps(const TurnProblem& problem, TurnProblem::Turns& turns);

}  // namespace mscomp
