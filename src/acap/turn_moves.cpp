// SPDX-License-Identifier: MIT
#include <cmath>
#include <deque>

#include "minimum_cut.h"
#include "turn_problem.h"

namespace mscomp {
namespace {

// Smaller gains are rounding: one turn changes an edge by up to (2π)² = 39.
constexpr double kGain = 1e-9;

/// Change of the energy of one edge when its ends i and j, or both, go up by a turn.
struct EdgeChange {
    double first, second, coupling;  // E(y) - E(0) = first y_i + second y_j + coupling y_i y_j
};

EdgeChange edge_change(const TurnProblem& problem, int i, int j, int up_i, int up_j,
                       const TurnProblem::Turns& turns) {
    const Eigen::Vector3d step_i = kTurn * up_i * problem.axis(i);
    const Eigen::Vector3d step_j = kTurn * up_j * problem.axis(j);
    const Eigen::Vector3d difference =
        problem.rotation_vector(i, turns[static_cast<std::size_t>(i)]) -
        problem.rotation_vector(j, turns[static_cast<std::size_t>(j)]);
    return {step_i.dot(step_i + 2 * difference), step_j.dot(step_j - 2 * difference),
            -2 * step_i.dot(step_j)};
}

/// Moves the best set of vertices up (direction +1) or down (-1); false if none lowers E.
bool move_best_cluster(const TurnProblem& problem, const std::vector<int>& orientation,
                       int direction, TurnProblem::Turns& turns) {
    const auto up = [&](int vertex) {
        return direction * orientation[static_cast<std::size_t>(vertex)];
    };
    MinimumCut cut(problem.vertex_count());
    for (const auto& [i, j] : problem.graph().edges) {
        const EdgeChange change = edge_change(problem, i, j, up(i), up(j), turns);
        if (problem.is_root(i) || problem.is_root(j)) {  // y of a root is 0, and no arc chooses it
            if (!problem.is_root(i)) cut.add_cost(i, change.first);
            if (!problem.is_root(j)) cut.add_cost(j, change.second);
            continue;
        }
        // y_i y_j = ½ (y_i + y_j - |y_i - y_j|). Where the axes disagree the coupling is positive
        // and the last term is left out: an upper bound, so that what seems to help does help.
        cut.add_cost(i, change.first + 0.5 * change.coupling);
        cut.add_cost(j, change.second + 0.5 * change.coupling);
        if (change.coupling < 0) cut.add_edge(i, j, -0.5 * change.coupling);
    }
    const std::vector<char> chosen = cut.solve();
    TurnProblem::Turns candidate = turns;
    for (int i = 0; i < problem.vertex_count(); ++i) {
        const auto v = static_cast<std::size_t>(i);
        if (chosen[v] != 0) candidate[v] += up(i);
    }
    if (candidate == turns || !(problem.energy(candidate) < problem.energy(turns) - kGain)) {
        return false;
    }
    turns = std::move(candidate);
    return true;
}

bool axes_agree(const TurnProblem& problem, const std::vector<int>& orientation) {
    for (const auto& [i, j] : problem.graph().edges) {
        const int sign =
            orientation[static_cast<std::size_t>(i)] * orientation[static_cast<std::size_t>(j)];
        if (sign * problem.axis(i).dot(problem.axis(j)) < 0) return false;
    }
    return true;
}

}  // namespace

void polish_vertices(const TurnProblem& problem, TurnProblem::Turns& turns) {
    const OneRings& rings = problem.graph().rings;
    std::deque<int> waiting;
    std::vector<char> queued(turns.size(), 1);
    for (int i = 0; i < problem.vertex_count(); ++i) waiting.push_back(i);
    while (!waiting.empty()) {
        const int vertex = waiting.front();
        waiting.pop_front();
        const auto v = static_cast<std::size_t>(vertex);
        queued[v] = 0;
        const int degree = rings.degree(vertex);
        if (degree == 0) continue;
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
            const int j = rings.neighbors[static_cast<std::size_t>(at)];
            sum += problem.rotation_vector(j, turns[static_cast<std::size_t>(j)]);
        }
        // As a function of x = θ + 2π t the energy is degree x² - 2 x a·sum + constant.
        const auto energy = [&](int turn) {
            const double x = problem.angle(vertex) + kTurn * turn;
            return x * (degree * x - 2 * problem.axis(vertex).dot(sum));
        };
        const int better = problem.nearest_turn(vertex, sum / degree);
        if (!(energy(better) < energy(turns[v]) - kGain)) continue;
        turns[v] = better;
        for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
            const int j = rings.neighbors[static_cast<std::size_t>(at)];
            if (queued[static_cast<std::size_t>(j)] != 0) continue;
            queued[static_cast<std::size_t>(j)] = 1;
            waiting.push_back(j);
        }
    }
}

bool polish_clusters(const TurnProblem& problem, const std::vector<int>& orientation,
                     TurnProblem::Turns& turns) {
    for (bool moved = true; moved;) {
        moved = move_best_cluster(problem, orientation, 1, turns);
        moved = move_best_cluster(problem, orientation, -1, turns) || moved;
        if (moved) polish_vertices(problem, turns);
    }
    return axes_agree(problem, orientation);
}

}  // namespace mscomp
