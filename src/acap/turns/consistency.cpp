// SPDX-License-Identifier: MIT
#include "consistency.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "mscomp/base/index.h"
#include "relaxed_turns.h"
#include "turn_jumps.h"
#include "turn_problem.h"
#include "turn_search.h"

namespace mscomp {
namespace {

constexpr double kSameUnrest = 1e-4;
// One turn changes an edge by up to (2π)² = 39; float vectors leave less than this over all edges.
constexpr double kSmallestGain = 1e-6;
// How far around what is not proved turns are relaxed.
constexpr int kDoubtRings = 3;

/// Copies of vertices that one search may look at.
std::int64_t most_effort(const TurnProblem& problem) {
    return 2000000 + 50 * static_cast<std::int64_t>(problem.vertex_count());
}

struct Candidate {
    TurnProblem::Turns turns;
    double energy;
};

/// The least energy of the searches from several starts, and the best of their bounds.
class BestTurns {
  public:
    /// No turns have less energy than `bound`.
    BestTurns(const TurnProblem& problem, Candidate start, double bound)
        : problem_(problem), best_(std::move(start)), bound_(bound) {}

    /// Searches from `start`; true if the best is proved to be least.
    bool search_from(Candidate start) {
        const SearchResult result = search_turns(problem_, most_effort(problem_), start.turns);
        bound_ = std::max(bound_, start.energy + result.bound);
        start.energy += result.change;
        if (start.energy < best_.energy - kSmallestGain) best_ = std::move(start);
        return reached();
    }
    bool reached() const { return best_.energy <= bound_ + 1e-9 * (1 + best_.energy); }
    const Candidate& best() const { return best_; }
    /// Of what is proved the energy itself, without the rounding of another sum.
    double bound() const { return reached() ? best_.energy : bound_; }

  private:
    const TurnProblem& problem_;
    Candidate best_;
    double bound_;
};

/// What the least that each edge can reach alone says of some turns.
struct TrivialBound {
    double value = 0;           // no turns have less energy
    std::vector<int> in_doubt;  // ends of edges that could reach less
};

TrivialBound trivial_bound(const TurnProblem& problem, const TurnProblem::Turns& turns) {
    TrivialBound bound;
    for (const auto& [i, j] : problem.graph().edges) {
        const double least = problem.edge_minimum(i, j);
        const double here =
            (problem.rotation_vector(i, turns[at(i)]) - problem.rotation_vector(j, turns[at(j)]))
                .squaredNorm();
        bound.value += least;
        if (here <= least + kSmallestGain) continue;
        bound.in_doubt.push_back(i);
        bound.in_doubt.push_back(j);
    }
    return bound;
}

/// `vertices` and what is at most `kDoubtRings` edges away from them, but no roots; ascending.
std::vector<int> surroundings(const TurnProblem& problem, const std::vector<int>& vertices) {
    const OneRings& rings = problem.graph().rings;
    std::vector<char> found(at(problem.vertex_count()), 0);
    std::vector<int> layer = vertices;
    for (const int v : layer) found[at(v)] = 1;
    for (int ring = 0; ring < kDoubtRings; ++ring) {
        std::vector<int> next;
        for (const int v : layer) {
            for (int place = rings.offsets[at(v)]; place < rings.offsets[at(v) + 1]; ++place) {
                const int j = rings.neighbors[at(place)];
                if (std::exchange(found[at(j)], 1) == 0) next.push_back(j);
            }
        }
        layer = std::move(next);
    }
    std::vector<int> result;
    for (int v = 0; v < problem.vertex_count(); ++v) {
        if (found[at(v)] != 0 && !problem.is_root(v)) result.push_back(v);
    }
    return result;
}

/// Propagation where each edge's own bound proves it. Elsewhere the relaxation is the start of the
/// search, or what has less energy; where that proves nothing the other starts follow.
Candidate best_turns(const TurnProblem& problem, ConsistencySummary& summary) {
    Candidate principal{TurnProblem::Turns(at(problem.vertex_count()), 0), 0};
    principal.energy = summary.principal_energy = problem.energy(principal.turns);
    Candidate propagated{problem.propagated(), 0};
    propagated.energy = summary.propagation_energy = problem.energy(propagated.turns);
    if (principal.energy < propagated.energy) std::swap(principal, propagated);
    const TrivialBound trivial = trivial_bound(problem, propagated.turns);
    BestTurns best(problem, propagated, trivial.value);
    if (!best.reached()) {
        Candidate relaxed{
            relaxed_turns(problem, propagated.turns, surroundings(problem, trivial.in_doubt)), 0};
        relaxed.energy = summary.relaxation_energy = problem.energy(relaxed.turns);
        relaxed.energy += polish_vertices(problem, relaxed.turns);
        if (propagated.energy < relaxed.energy) std::swap(propagated, relaxed);
        for (Candidate* start : {&relaxed, &propagated, &principal}) {
            if (start != &relaxed) start->energy += polish_vertices(problem, start->turns);
            if (best.search_from(std::move(*start))) break;
        }
    }
    summary.lower_bound = best.bound();
    return best.best();
}

void settle_jumps(const TurnProblem& problem, Candidate& best, ConsistencySummary& summary) {
    const LargeJumps jumps = settle_jumps(problem, best.turns);
    best.energy = std::min(best.energy, problem.energy(best.turns));
    summary.lower_bound = std::min(summary.lower_bound, best.energy);
    summary.largest_jump = jumps.largest;
    summary.large_jumps = jumps.count;
    summary.inherent_jumps = jumps.inherent;
    summary.removable_jumps = jumps.removable;
}

/// Vertices without a turn keep their vector bit for bit, exact also where the axis is free.
void turn_vectors(const TurnProblem& problem, const TurnProblem::Turns& turns,
                  std::vector<Eigen::Vector3d>& vectors) {
    for (std::size_t i = 0; i < turns.size(); ++i) {
        if (turns[i] == 0) continue;
        vectors[i] = problem.rotation_vector(static_cast<int>(i), turns[i]);
    }
}

}  // namespace

ConsistencyGraph consistency_graph(OneRings rings, const std::vector<double>& unrest) {
    ConsistencyGraph graph;
    graph.component = connected_components(rings);
    const auto components =
        graph.component.empty()
            ? 0
            : *std::max_element(graph.component.begin(), graph.component.end()) + 1;
    std::vector<double> least(at(components), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < unrest.size(); ++i) {
        double& value = least[at(graph.component[i])];
        value = std::min(value, unrest[i]);
    }
    graph.roots.assign(least.size(), -1);
    for (std::size_t i = 0; i < unrest.size(); ++i) {
        const auto component = at(graph.component[i]);
        int& root = graph.roots[component];
        if (root < 0 && unrest[i] <= least[component] + kSameUnrest) root = static_cast<int>(i);
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const int j = rings.neighbors[at(place)];
            if (static_cast<int>(i) < j) graph.edges.push_back({static_cast<int>(i), j});
        }
    }
    // Neighbours ascend, so the rings that name a vertex name it in their own order.
    graph.reverse.resize(rings.neighbors.size());
    std::vector<int> next(rings.offsets.begin(), rings.offsets.end() - 1);
    for (std::size_t k = 0; k < rings.neighbors.size(); ++k) {
        graph.reverse[k] = next[at(rings.neighbors[k])]++;
    }
    graph.rings = std::move(rings);
    return graph;
}

ConsistencySummary make_consistent(const ConsistencyGraph& graph,
                                   std::vector<Eigen::Vector3d>& rotation_vectors) {
    ConsistencySummary summary;
    const TurnProblem problem(graph, rotation_vectors);
    Candidate best = best_turns(problem, summary);
    settle_jumps(problem, best, summary);
    summary.energy = best.energy;
    turn_vectors(problem, best.turns, rotation_vectors);
    return summary;
}

bool improve_consistency(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& start,
                         std::vector<Eigen::Vector3d>& rotation_vectors,
                         ConsistencySummary& summary) {
    if (summary.energy <= summary.lower_bound) return false;
    // Turns count from the vectors as they are: their axes are known also near a full turn.
    const TurnProblem problem(graph, rotation_vectors);
    Candidate other{TurnProblem::Turns(rotation_vectors.size(), 0), 0};
    const double before = problem.energy(other.turns);
    for (std::size_t i = 0; i < other.turns.size(); ++i) {
        other.turns[i] = problem.nearest_turn(static_cast<int>(i), start[i]);
    }
    polish_vertices(problem, other.turns);
    search_turns(problem, most_effort(problem), other.turns);
    other.energy = problem.energy(other.turns);
    if (!(other.energy < before - kSmallestGain)) return false;
    settle_jumps(problem, other, summary);
    summary.energy = other.energy;
    summary.lower_bound = std::min(summary.lower_bound, other.energy);
    turn_vectors(problem, other.turns, rotation_vectors);
    return true;
}

}  // namespace mscomp
