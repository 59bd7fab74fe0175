// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "turn_problem.h"

namespace mscomp {

/// Lowers E by moves of single vertices, those in `waiting` first and then whatever they disturb.
/// \return what E changed by
double polish_vertices(const TurnProblem& problem, std::vector<int> waiting,
                       TurnProblem::Turns& turns);
double polish_vertices(const TurnProblem& problem, TurnProblem::Turns& turns);

struct SearchResult {
    double change = 0;  // of E from the given turns to the result, never above 0
    double bound = 0;   // no turns change E by less than this; equals `change` where proved
    bool proved = false;
    int visited = 0;          // subproblems
    std::int64_t effort = 0;  // copies of vertices that cuts looked at, and vertices tried
};

/// Looks for the turns of least energy, from `turns`, which it replaces by the best found: branch
/// and bound with TurnCover as the bound. A subproblem whose cover has its minimum at t = t' is
/// solved; one whose bound is not below the best is dropped; otherwise a vertex with t != t' is
/// confined to either half of its turns. The first subproblem is always solved; no other is begun
/// once `most_effort` is spent, nor more than 1000 levels deep.
SearchResult search_turns(const TurnProblem& problem, std::int64_t most_effort,
                          TurnProblem::Turns& turns);

}  // namespace mscomp
