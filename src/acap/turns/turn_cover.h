// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "mscomp/base/index.h"
#include "turn_problem.h"

namespace mscomp {

/// A relaxation of TurnProblem that can be solved exactly. Every vertex i has two copies with turns
/// t_i and t'_i, read along its axis and against it: X_i = θ_i + 2π t_i and X'_i = -(θ_i + 2π
/// t'_i). An edge connects the copies whose directions agree: X_i with X_j and X'_i with X'_j where
/// a_i·a_j >= 0, X_i with X'_j and X'_i with X_j otherwise. Each of the two costs half of
/// X² + Y² - 2 |a_i·a_j| X Y = (1 - c)(X² + Y²) + c (X - Y)², so that the energy is L-natural
/// convex: it is least where no set of copies, moved by one turn up or down, lowers it (Murota),
/// and the best set is a minimum cut. With t = t' it is E(t); so its minimum is never above that of
/// E, and if t = t' at the minimum, t is a minimum of E. With turns in {0, 1} this is roof duality.
class TurnCover {
  public:
    using Turns = TurnProblem::Turns;

    /// Starts at t = t' = `start`. Keeps a reference to `problem`.
    TurnCover(const TurnProblem& problem, const Turns& start);

    int turn(int vertex) const { return turn_[2 * at(vertex)]; }
    int opposite_turn(int vertex) const { return turn_[2 * at(vertex) + 1]; }
    /// What the energy has changed by since the start.
    double change() const { return change_; }

    /// Moves the best set of copies by one turn, along their directions (+1) or against (-1).
    /// \return whether that lowered the energy
    bool move_best_set(int direction);
    /// Moves sets until none helps; what remains is the minimum.
    void minimize();
    /// From now on lower <= t, t' <= upper at `vertex` (no root); turns outside go to the limit.
    void confine(int vertex, int lower, int upper);
    int lower(int vertex) const { return limits_[at(vertex)].lower; }
    int upper(int vertex) const { return limits_[at(vertex)].upper; }

    /// Vertices moved since the start, some more than once.
    const std::vector<int>& moved() const { return moved_; }

    /// Copies opened, levelled and discharged in all cuts so far: a measure of the work.
    std::int64_t effort() const { return effort_; }

    /// A state to come back to.
    struct Mark {
        std::size_t steps, confined, watched;
        double change;
    };
    Mark mark() const { return {steps_.size(), confined_.size(), watched_.size(), change_}; }
    void return_to(const Mark& mark);

  private:
    static constexpr int kUnreachable = std::numeric_limits<int>::max() / 2;
    static constexpr int kFar = std::numeric_limits<int>::max() / 2;
    struct Limits {
        int lower = -kFar, upper = kFar;
    };
    struct Step {
        int node, turn;  // as it was before
    };
    struct Confined {
        int vertex;
        Limits limits;  // as they were before
    };

    // Node 2 i is the copy of vertex i along its axis, node 2 i + 1 the one against it. Arc
    // 2 k + (tail & 1) leaves a node over place k of the rings.
    std::size_t head(std::size_t place, std::size_t tail) const;
    double capacity(std::size_t place, std::size_t tail, std::size_t head) const;
    void open(std::size_t node);
    void set_level_of_opened(std::size_t node);
    double room(std::size_t place, std::size_t tail, std::size_t head) const;
    void measure_levels();
    void lift(std::size_t node);
    void discharge(std::size_t node);
    double maximum_flow();
    void collect_reached();
    void forget_flow();
    void set_turn(std::size_t node, int turn);
    void watch(int vertex);
    void watch_ring(int vertex);
    double local_energy(std::size_t node) const;

    const TurnProblem& problem_;
    const OneRings& rings_;
    std::vector<int> turn_;      // (2V) t and t' in turns
    std::vector<double> value_;  // (2V) X and X'
    std::vector<Limits> limits_;
    double change_ = 0;
    std::int64_t effort_ = 0;
    std::vector<Step> steps_;
    std::vector<int> moved_;
    std::vector<Confined> confined_;
    std::vector<int> watched_;  // vertices that can have something to gain from a move
    std::vector<char> is_watched_;

    // One cut: only nodes near those with something to gain are ever opened.
    int direction_ = 1;
    std::vector<std::size_t> opened_;
    std::vector<char> is_open_;
    std::vector<double> excess_;  // (2V) gain of moving the node that no flow has used up
    std::vector<double> flow_;    // per arc
    std::vector<int> level_;      // (2V) at most the number of arcs with room to a sink, plus one
    std::vector<int> at_level_;   // opened nodes per level
    std::vector<int> next_;       // (2V) place of the ring to go on with
    std::size_t lifts_ = 0;       // since levels were measured
    std::vector<std::size_t> sources_, active_, queue_;
};

}  // namespace mscomp
