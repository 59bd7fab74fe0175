// SPDX-License-Identifier: MIT
#include "turn_jumps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "mscomp/base/index.h"
#include "turn_cover.h"

namespace mscomp {
namespace {

// Half turns are as frequent as data with mirror symmetry; vectors rounded to float must not decide
// whether a jump of π is above π.
constexpr double kLarge = std::numbers::pi * (1 + 1e-6);
constexpr double kLargeSquared = kLarge * kLarge;
// One turn changes an edge by up to (2π)² = 39: less is rounding.
constexpr double kSameEnergy = 1e-9;
// Copies of vertices looked at: at least this many, and so many per vertex.
constexpr std::int64_t kEffort = 500000;
constexpr std::int64_t kEffortPerVertex = 20;
constexpr int kFar = 1 << 20;

double squared_jump(const TurnProblem& problem, int i, int turn_i, int j, int turn_j) {
    return (problem.rotation_vector(i, turn_i) - problem.rotation_vector(j, turn_j)).squaredNorm();
}

using Edge = std::array<int, 2>;

/// What holding an edge at π or below leads to.
enum class Outcome { costs_energy, open, removed };

class Settling {
  public:
    Settling(const TurnProblem& problem, TurnProblem::Turns& turns)
        : problem_(problem),
          turns_(turns),
          cover_(problem, turns),
          most_effort_(kEffort + kEffortPerVertex * problem.vertex_count()) {
        cover_.minimize();
    }

    /// Settles the edges, and those that become large instead; each success leaves fewer large
    /// ones. \return those whose removal costs energy: that holds for all turns of no more energy
    std::set<Edge> settle(std::vector<Edge> waiting) {
        std::set<Edge> costly, queued(waiting.begin(), waiting.end());
        for (std::size_t next = 0; next < waiting.size() && !spent(); ++next) {
            const auto [i, j] = waiting[next];
            queued.erase(waiting[next]);
            if (jump(i, j) <= kLargeSquared) continue;
            const Outcome outcome = settle(i, j);
            if (outcome == Outcome::costs_energy) costly.insert({i, j});
            if (outcome != Outcome::removed) continue;
            for (const Edge& edge : disturbed_) {
                if (costly.count(edge) != 0 || !queued.insert(edge).second) continue;
                waiting.push_back(edge);
            }
        }
        return costly;
    }
    std::int64_t effort() const { return cover_.effort() + looked_at_; }

  private:
    double jump(int i, int j) const {
        return squared_jump(problem_, i, turns_[at(i)], j, turns_[at(j)]);
    }

    Outcome settle(int i, int j) {
        const int now = turns_[at(i)];
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

    /// With i at `turn`, all turns of j within π of it.
    Outcome hold_near(int i, int turn, int j) {
        const double along = problem_.axis(j).dot(problem_.rotation_vector(i, turn));
        const auto nearest = static_cast<int>(std::lround((along - problem_.angle(j)) / kTurn));
        Outcome outcome = Outcome::costs_energy;
        for (int other = nearest - 1; other <= nearest + 1; ++other) {
            if (squared_jump(problem_, i, turn, j, other) > kLargeSquared) continue;
            outcome = std::max(outcome, hold(i, turn, turn, j, other, other));
            if (outcome == Outcome::removed) break;
        }
        return outcome;
    }

    /// Whether all turns of a vertex on one side of the present one cost energy.
    bool moving_costs_energy(int vertex, int now, int step) {
        const std::size_t key = 2 * at(vertex) + (step > 0 ? 1 : 0);
        const auto [known, fresh] = moving_.try_emplace(key, false);
        if (!fresh) return known->second;
        if (problem_.is_root(vertex)) return known->second = true;
        if (spent()) return false;
        const TurnCover::Mark mark = cover_.mark();
        cover_.confine(vertex, step > 0 ? now + 1 : -kFar, step > 0 ? kFar : now - 1);
        cover_.minimize();
        known->second = cover_.change() > fallen_ + kSameEnergy;
        cover_.return_to(mark);
        return known->second;
    }

    bool spent() const { return effort() >= most_effort_; }

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
        if (cover_.change() <= fallen_ + kSameEnergy) {
            outcome = take(i, j) ? Outcome::removed : Outcome::open;
        }
        cover_.return_to(mark);
        return outcome;
    }

    /// Replaces the turns by those of the cover if that costs nothing, brings the edge to π or
    /// below and leaves fewer large jumps than before.
    bool take(int i, int j) {
        std::vector<int> moved = cover_.moved();
        std::sort(moved.begin(), moved.end());
        moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
        looked_at_ += static_cast<std::int64_t>(moved.size());
        std::erase_if(moved, [&](int vertex) { return turns_[at(vertex)] == cover_.turn(vertex); });
        const std::size_t large_before = large_edges_at(moved).size();
        std::vector<int> before;
        double change = 0;
        for (const int vertex : moved) {
            int& turn = turns_[at(vertex)];
            before.push_back(turn);
            change += problem_.change(turns_, vertex, cover_.turn(vertex));
            turn = cover_.turn(vertex);
        }
        disturbed_ = large_edges_at(moved);
        if (change <= kSameEnergy && jump(i, j) <= kLargeSquared &&
            disturbed_.size() < large_before) {
            fallen_ += std::min(change, 0.0);
            for (const int vertex : moved) {
                moving_.erase(2 * at(vertex));
                moving_.erase(2 * at(vertex) + 1);
            }
            std::erase_if(disturbed_, [&](const Edge& edge) {
                return problem_.edge_minimum(edge[0], edge[1]) > kLargeSquared;
            });
            return true;
        }
        for (std::size_t k = 0; k < moved.size(); ++k) {
            turns_[at(moved[k])] = before[k];
        }
        return false;
    }

    std::vector<Edge> large_edges_at(const std::vector<int>& vertices) {
        const OneRings& rings = problem_.graph().rings;
        std::vector<Edge> edges;
        for (const int i : vertices) {
            const auto v = at(i);
            looked_at_ += rings.degree(i);
            for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
                const int j = rings.neighbors[at(place)];
                if (jump(i, j) > kLargeSquared) edges.push_back({std::min(i, j), std::max(i, j)});
            }
        }
        std::sort(edges.begin(), edges.end());
        edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
        return edges;
    }

    const TurnProblem& problem_;
    TurnProblem::Turns& turns_;
    TurnCover cover_;
    std::int64_t most_effort_;
    std::int64_t looked_at_ = 0;  // vertices and edges, outside of cuts
    double fallen_ = 0;           // energy of the turns against that at the start, never above 0
    std::map<std::size_t, bool> moving_;
    std::vector<Edge> disturbed_;  // large and avoidable at the vertices that moved last
};

struct Survey {
    LargeJumps jumps;
    std::vector<Edge> avoidable;  // edges above π that need not be, by themselves
};

Survey survey(const TurnProblem& problem, const TurnProblem::Turns& turns) {
    std::vector<Eigen::Vector3d> vectors(turns.size());
    for (std::size_t i = 0; i < turns.size(); ++i) {
        vectors[i] = problem.rotation_vector(static_cast<int>(i), turns[i]);
    }
    Survey found;
    for (const auto& [i, j] : problem.graph().edges) {
        const double squared = (vectors[at(i)] - vectors[at(j)]).squaredNorm();
        found.jumps.largest = std::max(found.jumps.largest, squared);
        if (squared <= kLargeSquared) continue;
        ++found.jumps.count;
        if (problem.edge_minimum(i, j) > kLargeSquared) {
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
    if (found.avoidable.empty()) return found.jumps;
    Settling settling(problem, turns);
    const std::set<Edge> costly = settling.settle(found.avoidable);
    found = survey(problem, turns);
    for (const Edge& edge : found.avoidable) {
        if (costly.count(edge) == 0) ++found.jumps.removable;
    }
    found.jumps.effort = settling.effort();
    return found.jumps;
}

}  // namespace mscomp
