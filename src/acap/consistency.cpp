// SPDX-License-Identifier: MIT
#include "consistency.h"

#include <algorithm>
#include <limits>

#include "turn_problem.h"

namespace mscomp {
namespace {

constexpr double kSameUnrest = 1e-4;
// One turn changes an edge by up to (2π)² = 39; float vectors leave less than this over all edges.
constexpr double kSmallestGain = 1e-6;

struct Candidate {
    TurnProblem::Turns turns;
    double energy;
};

double largest_jump(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& vectors) {
    double largest = 0;
    for (const auto& [i, j] : graph.edges) {
        const double jump =
            (vectors[static_cast<std::size_t>(i)] - vectors[static_cast<std::size_t>(j)]).norm();
        largest = std::max(largest, jump);
    }
    return largest;
}

bool reaches(double energy, double bound) { return energy <= bound + 1e-9 * (1 + bound); }

/// The polished best of the cheap starts; where that is not proved best, the relaxation as well.
Candidate best_turns(const TurnProblem& problem, ConsistencySummary& summary) {
    Candidate best{TurnProblem::Turns(static_cast<std::size_t>(problem.vertex_count()), 0), 0};
    best.energy = summary.principal_energy = problem.energy(best.turns);
    const auto keep_better = [&](TurnProblem::Turns turns) {
        const double energy = problem.energy(turns);
        if (energy < best.energy) best = {std::move(turns), energy};
    };
    summary.lower_bound = std::min(problem.lower_bound(), best.energy);

    const TurnProblem::Turns propagated = problem.propagated();
    summary.propagation_energy = problem.energy(propagated);
    if (reaches(best.energy, summary.lower_bound)) return best;

    const std::vector<int> orientation = problem.orientation();
    const auto polished = [&](TurnProblem::Turns turns) {
        polish_vertices(problem, turns);
        keep_better(turns);
        if (reaches(best.energy, summary.lower_bound)) return true;
        const bool proved = polish_clusters(problem, orientation, turns);
        keep_better(std::move(turns));
        if (proved) summary.lower_bound = best.energy;
        return proved || reaches(best.energy, summary.lower_bound);
    };
    const TurnProblem::Turns principal = best.turns;
    const bool propagation_first = summary.propagation_energy < summary.principal_energy;
    if (polished(propagation_first ? propagated : principal)) return best;
    if (polished(propagation_first ? principal : propagated)) return best;
    TurnProblem::Turns relaxed = relaxed_turns(problem);
    summary.relaxation_energy = problem.energy(relaxed);
    keep_better(relaxed);
    polished(std::move(relaxed));
    return best;
}

}  // namespace

ConsistencyGraph consistency_graph(OneRings rings, const std::vector<double>& unrest) {
    ConsistencyGraph graph;
    graph.component = connected_components(rings);
    const auto components =
        graph.component.empty()
            ? 0
            : *std::max_element(graph.component.begin(), graph.component.end()) + 1;
    std::vector<double> least(static_cast<std::size_t>(components),
                              std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < unrest.size(); ++i) {
        double& value = least[static_cast<std::size_t>(graph.component[i])];
        value = std::min(value, unrest[i]);
    }
    graph.roots.assign(least.size(), -1);
    for (std::size_t i = 0; i < unrest.size(); ++i) {
        const auto component = static_cast<std::size_t>(graph.component[i]);
        int& root = graph.roots[component];
        if (root < 0 && unrest[i] <= least[component] + kSameUnrest) root = static_cast<int>(i);
        for (int at = rings.offsets[i]; at < rings.offsets[i + 1]; ++at) {
            const int j = rings.neighbors[static_cast<std::size_t>(at)];
            if (static_cast<int>(i) < j) graph.edges.push_back({static_cast<int>(i), j});
        }
    }
    graph.rings = std::move(rings);
    return graph;
}

ConsistencySummary make_consistent(const ConsistencyGraph& graph,
                                   std::vector<Eigen::Vector3d>& rotation_vectors) {
    ConsistencySummary summary;
    const TurnProblem problem(graph, rotation_vectors);
    const Candidate best = best_turns(problem, summary);
    summary.energy = best.energy;
    for (std::size_t i = 0; i < rotation_vectors.size(); ++i) {
        // Without a turn the principal logarithm stays as it is, exact also where the axis is free.
        if (best.turns[i] == 0) continue;
        rotation_vectors[i] = problem.rotation_vector(static_cast<int>(i), best.turns[i]);
    }
    summary.largest_jump = largest_jump(graph, rotation_vectors);
    return summary;
}

bool improve_consistency(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& start,
                         std::vector<Eigen::Vector3d>& rotation_vectors,
                         ConsistencySummary& summary) {
    if (reaches(summary.energy, summary.lower_bound)) return false;
    // Turns count from the vectors as they are: their axes are known also near a full turn.
    const TurnProblem problem(graph, rotation_vectors);
    TurnProblem::Turns turns(rotation_vectors.size());
    const double before = problem.energy(turns);
    for (std::size_t i = 0; i < turns.size(); ++i) {
        turns[i] = problem.nearest_turn(static_cast<int>(i), start[i]);
    }
    polish_vertices(problem, turns);
    polish_clusters(problem, problem.orientation(), turns);
    const double after = problem.energy(turns);
    if (!(after < before - kSmallestGain)) return false;
    for (std::size_t i = 0; i < turns.size(); ++i) {
        if (turns[i] != 0) {
            rotation_vectors[i] = problem.rotation_vector(static_cast<int>(i), turns[i]);
        }
    }
    summary.energy = after;
    summary.lower_bound = std::min(summary.lower_bound, after);
    summary.largest_jump = largest_jump(graph, rotation_vectors);
    return true;
}

}  // namespace mscomp
