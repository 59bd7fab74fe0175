// SPDX-License-Identifier: MIT
#pragma once

#include "turn_problem.h"

namespace mscomp {

/// The least-squares solution over real turns (one sparse solve by Ceres), rounded.
TurnProblem::Turns relaxed_turns(const TurnProblem& problem);

}  // namespace mscomp
