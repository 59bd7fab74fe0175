// SPDX-License-Identifier: MIT
#include "turn_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/index.h"
#include "turn_cover.h"

namespace mscomp {
namespace {

// One turn changes an edge by up to (2π)² = 39: less is rounding.
constexpr double kGain = 1e-9;
// Levels of subproblems: each is a call within a call on the stack of a worker thread.
constexpr int kMostDepth = 1000;

}  // namespace

double polish_vertices(const TurnProblem& problem, std::vector<int> waiting,
                       TurnProblem::Turns& turns) {
    const OneRings& rings = problem.graph().rings;
    std::vector<char> queued(turns.size(), 0);
    for (const int vertex : waiting) queued[at(vertex)] = 1;
    double change = 0;
    for (std::size_t first = 0; first < waiting.size(); ++first) {
        const int vertex = waiting[first];
        const auto v = at(vertex);
        queued[v] = 0;
        const int better = problem.best_turn(turns, vertex);
        if (better == turns[v]) continue;
        const double gain = problem.change(turns, vertex, better);
        if (!(gain < -kGain)) continue;
        change += gain;
        turns[v] = better;
        for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
            const int j = rings.neighbors[at(place)];
            if (queued[at(j)] != 0) continue;
            queued[at(j)] = 1;
            waiting.push_back(j);
        }
    }
    return change;
}

double polish_vertices(const TurnProblem& problem, TurnProblem::Turns& turns) {
    std::vector<int> all(turns.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    return polish_vertices(problem, std::move(all), turns);
}

namespace {

class Search {
  public:
    Search(const TurnProblem& problem, std::int64_t most_effort, const TurnProblem::Turns& turns)
        : problem_(problem),
          most_effort_(most_effort),
          best_(turns),
          differs_(turns.size(), 0),
          cover_(problem, turns) {}

    SearchResult run() {
        explore(0);
        SearchResult result;
        result.change = best_change_;
        result.bound = std::min(best_change_, open_bound_);
        result.proved = result.bound >= best_change_ - kGain;
        result.visited = visited_;
        result.effort = cover_.effort() + looked_at_;
        return result;
    }
    const TurnProblem::Turns& best() const { return best_; }

  private:
    bool hopeless() const { return cover_.change() >= best_change_ - kGain; }

    bool spent() const { return cover_.effort() + looked_at_ >= most_effort_; }

    /// Solves, drops or divides the subproblem of the cover's present limits.
    void explore(int depth) {
        ++visited_;
        cover_.minimize();
        if (hopeless()) return;
        const int vertex = try_what_is_found();
        if (vertex < 0 || hopeless()) return;
        const double bound = cover_.change();
        const int first = cover_.turn(vertex), second = cover_.opposite_turn(vertex);
        const int middle = std::min(first, second) + std::abs(first - second) / 2;
        const bool low_first = best_[at(vertex)] <= middle;
        for (const bool low : {low_first, !low_first}) {
            if (spent() || depth == kMostDepth) {
                open_bound_ = std::min(open_bound_, bound);
                return;
            }
            const TurnCover::Mark mark = cover_.mark();
            cover_.confine(vertex, low ? cover_.lower(vertex) : middle + 1,
                           low ? middle : cover_.upper(vertex));
            explore(depth + 1);
            cover_.return_to(mark);
        }
    }

    /// The vertex to divide the subproblem at; -1 if it is solved.
    int try_what_is_found() {
        const std::vector<int> torn = take_what_helps();
        if (!torn.empty()) return widest(torn);
        if (!hopeless()) take_all();
        return -1;
    }

    /// The best may come from elsewhere, so that no patch of what moved here leads to t.
    void take_all() {
        for (std::size_t i = 0; i < best_.size(); ++i) best_[i] = cover_.turn(static_cast<int>(i));
        best_change_ = cover_.change();
        looked_at_ += static_cast<std::int64_t>(best_.size());
    }

    /// Lowers the best by what the cover proposes, patch by patch; returns the vertices where t and
    /// t' differ.
    std::vector<int> take_what_helps() {
        std::vector<int> moved = cover_.moved();
        looked_at_ += static_cast<std::int64_t>(moved.size());
        std::sort(moved.begin(), moved.end());
        moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
        std::vector<int> torn;
        for (const int vertex : moved) {
            const auto v = at(vertex);
            const int turn = cover_.turn(vertex), opposite = cover_.opposite_turn(vertex);
            if (turn != opposite) torn.push_back(vertex);
            differs_[v] = turn != best_[v] || opposite != best_[v] ? 1 : 0;
        }
        std::vector<int> changed;
        for (const int vertex : moved) {
            if (differs_[at(vertex)] == 0) continue;
            take_best_of_patch(patch_around(vertex), changed);
        }
        if (!changed.empty()) best_change_ += polish_vertices(problem_, changed, best_);
        return torn;
    }

    /// The connected set of differing vertices that contains `vertex`, which differ no more.
    std::vector<int> patch_around(int vertex) {
        const OneRings& rings = problem_.graph().rings;
        std::vector<int> patch{vertex};
        differs_[at(vertex)] = 0;
        for (std::size_t first = 0; first < patch.size(); ++first) {
            const auto v = at(patch[first]);
            for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
                const int j = rings.neighbors[at(place)];
                if (differs_[at(j)] == 0) continue;
                differs_[at(j)] = 0;
                patch.push_back(j);
            }
        }
        return patch;
    }

    /// Of t, t', t where both agree, and the best as it is: what is least on this patch.
    void take_best_of_patch(const std::vector<int>& patch, std::vector<int>& changed) {
        const auto proposal = [&](int choice, int vertex) {
            const int turn = cover_.turn(vertex), opposite = cover_.opposite_turn(vertex);
            if (choice == 2 && turn != opposite) return best_[at(vertex)];
            return choice == 1 ? opposite : turn;
        };
        std::vector<int> before, better;
        for (const int vertex : patch) before.push_back(best_[at(vertex)]);
        double least = -kGain;
        for (int choice = 0; choice < 3; ++choice) {
            std::vector<int> turns;
            for (const int vertex : patch) turns.push_back(proposal(choice, vertex));
            double change = 0;
            for (std::size_t k = 0; k < patch.size(); ++k) {
                change += problem_.change(best_, patch[k], turns[k]);
                best_[at(patch[k])] = turns[k];
            }
            for (std::size_t k = 0; k < patch.size(); ++k) {
                best_[at(patch[k])] = before[k];
            }
            if (change >= least) continue;
            least = change;
            better = std::move(turns);
        }
        if (better.empty()) return;
        best_change_ += least;
        for (std::size_t k = 0; k < patch.size(); ++k) {
            best_[at(patch[k])] = better[k];
            changed.push_back(patch[k]);
        }
    }

    int widest(const std::vector<int>& torn) const {
        const OneRings& rings = problem_.graph().rings;
        const auto tear = [&](int vertex) {
            return std::abs(cover_.turn(vertex) - cover_.opposite_turn(vertex));
        };
        int best = torn.front();
        int most = -1;
        for (const int vertex : torn) {
            int weight = 64 * tear(vertex);
            const auto v = at(vertex);
            for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
                weight += tear(rings.neighbors[at(place)]) != 0 ? 1 : 0;
            }
            if (weight <= most) continue;
            most = weight;
            best = vertex;
        }
        return best;
    }

    const TurnProblem& problem_;
    std::int64_t most_effort_;
    TurnProblem::Turns best_;
    std::vector<char> differs_;  // (V), all 0 between calls
    double best_change_ = 0;
    double open_bound_ = std::numeric_limits<double>::infinity();
    int visited_ = 0;
    std::int64_t looked_at_ = 0;  // vertices, outside of cuts
    TurnCover cover_;
};

}  // namespace

SearchResult search_turns(const TurnProblem& problem, std::int64_t most_effort,
                          TurnProblem::Turns& turns) {
    Search search(problem, most_effort, turns);
    const SearchResult result = search.run();
    turns = search.best();
    return result;
}

}  // namespace mscomp
