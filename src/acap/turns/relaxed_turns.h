// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turn_problem.h"

namespace mscomp {

/// The least-squares solution over real turns of the vertices in `free` (ascending, roots left
/// out), all others held at `turns`; rounded. One sparse solve by Ceres.
TurnProblem::Turns relaxed_turns(const TurnProblem& problem, TurnProblem::Turns turns,
                                 const std::vector<int>& free);

/// The same with all vertices but the roots free.
TurnProblem::Turns relaxed_turns(const TurnProblem& problem);

}  // namespace mscomp
