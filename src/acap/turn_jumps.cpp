// SPDX-License-Identifier: MIT
#include "turn_jumps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>

#include "turn_cover.h"

namespace mscomp {
namespace {

constexpr double kPi = std::numbers::pi;
// One turn changes an edge by up to (2π)² = 39: less is rounding.
constexpr double kSameEnergy = 1e-9;
constexpr std::int64_t kMostEffort = 500000;
constexpr int kFar = 1 << 20;

double squared_jump(const TurnProblem& problem, int i, int turn_i, int j, int turn_j) {
    return (problem.rotation_vector(i, turn_i) - problem.rotation_vector(j, turn_j)).squaredNorm();
}

/// What holding an edge at π or below leads to.
enum class Outcome { costs_energy, open, removed };

class Settling {
  public:
    Settling(const TurnProblem& problem, TurnProblem::Turns& turns)
        : problem_(problem), turns_(turns), cover_(problem, turns) {
        cover_.minimize();
    }

    Outcome settle(int i, int j) {
        const int now = turns_[static_cast<std::size_t>(i)];
        Outcome outcome = hold_near(i, now, j);
        for (const int step : {1, -1}) {
            if (outcome == Outcome::removed) break;
            if (moving_costs_energy(i, now, step)) continue;
            const int beyond = now + 2 * step;
            outcome = std::max(outcome, hold_near(i, now + step, j));
            if (outcome == Outcome::removed) break;
            outcome = std::max(outcome, hold(i, step > 0 ? beyond : -kFar, step > 0 ? kFar : beyond,
                                             j, -kFar, kFar));
        }
        return outcome;
    }

  private:
    /// With i at `turn`, all turns of j within π of it.
    Outcome hold_near(int i, int turn, int j) {
        const double along = problem_.axis(j).dot(problem_.rotation_vector(i, turn));
        const auto nearest = static_cast<int>(std::lround((along - problem_.angle(j)) / kTurn));
        Outcome outcome = Outcome::costs_energy;
        for (int other = nearest - 1; other <= nearest + 1; ++other) {
            if (squared_jump(problem_, i, turn, j, other) > kPi * kPi) continue;
            outcome = std::max(outcome, hold(i, turn, turn, j, other, other));
            if (outcome == Outcome::removed) break;
        }
        return outcome;
    }

    /// Whether all turns of a vertex on one side of the present one cost energy.
    bool moving_costs_energy(int vertex, int now, int step) {
        const std::size_t key = 2 * static_cast<std::size_t>(vertex) + (step > 0 ? 1 : 0);
        const auto [known, fresh] = moving_.try_emplace(key, false);
        if (!fresh) return known->second;
        if (problem_.is_root(vertex)) return known->second = true;
        if (spent()) return false;
        const TurnCover::Mark mark = cover_.mark();
        cover_.confine(vertex, step > 0 ? now + 1 : -kFar, step > 0 ? kFar : now - 1);
        cover_.minimize();
        known->second = cover_.change() > kSameEnergy;
        cover_.return_to(mark);
        return known->second;
    }

    bool spent() const { return cover_.effort() >= kMostEffort; }

    Outcome hold(int i, int lowest_i, int highest_i, int j, int lowest_j, int highest_j) {
        const auto excludes = [&](int vertex, int lowest, int highest) {
            return problem_.is_root(vertex) && (lowest > 0 || highest < 0);
        };
        if (excludes(i, lowest_i, highest_i) || excludes(j, lowest_j, highest_j)) {
            return Outcome::costs_energy;
        }
        if (spent()) return Outcome::open;
        const TurnCover::Mark mark = cover_.mark();
        cover_.confine(i, lowest_i, highest_i);
        cover_.confine(j, lowest_j, highest_j);
        cover_.minimize();
        Outcome outcome = Outcome::costs_energy;
        if (cover_.change() <= kSameEnergy) outcome = take(i, j) ? Outcome::removed : Outcome::open;
        cover_.return_to(mark);
        return outcome;
    }

    /// Replaces the turns by those of the cover if that costs nothing and helps the edge.
    bool take(int i, int j) {
        TurnProblem::Turns trial = turns_;
        double change = 0;
        for (const int vertex : cover_.moved()) {
            change += problem_.change(trial, vertex, cover_.turn(vertex));
            trial[static_cast<std::size_t>(vertex)] = cover_.turn(vertex);
        }
        const double jump = squared_jump(problem_, i, trial[static_cast<std::size_t>(i)], j,
                                         trial[static_cast<std::size_t>(j)]);
        if (change > kSameEnergy || jump > kPi * kPi) return false;
        turns_ = std::move(trial);
        return true;
    }

    const TurnProblem& problem_;
    TurnProblem::Turns& turns_;
    TurnCover cover_;
    std::map<std::size_t, bool> moving_;
};

struct Survey {
    LargeJumps jumps;
    std::vector<std::array<int, 2>> avoidable;  // edges above π that need not be, by themselves
};

Survey survey(const TurnProblem& problem, const TurnProblem::Turns& turns) {
    std::vector<Eigen::Vector3d> vectors(turns.size());
    for (std::size_t i = 0; i < turns.size(); ++i) {
        vectors[i] = problem.rotation_vector(static_cast<int>(i), turns[i]);
    }
    Survey found;
    for (const auto& [i, j] : problem.graph().edges) {
        const double squared =
            (vectors[static_cast<std::size_t>(i)] - vectors[static_cast<std::size_t>(j)])
                .squaredNorm();
        found.jumps.largest = std::max(found.jumps.largest, squared);
        if (squared <= kPi * kPi) continue;
        ++found.jumps.count;
        if (problem.edge_minimum(i, j) > kPi * kPi) {
            ++found.jumps.inherent;
        } else {
            found.avoidable.push_back({i, j});
        }
    }
    found.jumps.largest = std::sqrt(found.jumps.largest);
    return found;
}

}  // namespace

LargeJumps settle_jumps(const TurnProblem& problem, TurnProblem::Turns& turns) {
    Survey found = survey(problem, turns);
    // Each round but the last has fewer large jumps than the one before.
    while (!found.avoidable.empty()) {
        TurnProblem::Turns trial = turns;
        Settling settling(problem, trial);
        bool removed = false;
        found.jumps.removable = 0;
        for (const auto& [i, j] : found.avoidable) {
            const Outcome outcome = settling.settle(i, j);
            if (outcome != Outcome::costs_energy) ++found.jumps.removable;
            removed = outcome == Outcome::removed;
            if (removed) break;
        }
        if (!removed) break;
        Survey after = survey(problem, trial);
        if (after.jumps.count >= found.jumps.count) break;
        turns = std::move(trial);
        found = std::move(after);
    }
    return found.jumps;
}

}  // namespace mscomp
