// SPDX-License-Identifier: MIT
#include "turn_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mscomp {
namespace {

// One turn changes an edge by up to (2π)² = 39: less is rounding.
constexpr double kGain = 1e-9;

}  // namespace

double polish_vertices(const TurnProblem& problem, std::vector<int> waiting,
                       TurnProblem::Turns& turns) {
    const OneRings& rings = problem.graph().rings;
    std::vector<char> queued(turns.size(), 0);
    for (const int vertex : waiting) queued[static_cast<std::size_t>(vertex)] = 1;
    double change = 0;
    for (std::size_t first = 0; first < waiting.size(); ++first) {
        const int vertex = waiting[first];
        const auto v = static_cast<std::size_t>(vertex);
        queued[v] = 0;
        const int better = problem.best_turn(turns, vertex);
        if (better == turns[v]) continue;
        const double gain = problem.change(turns, vertex, better);
        if (!(gain < -kGain)) continue;
        change += gain;
        turns[v] = better;
        for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
            const int j = rings.neighbors[static_cast<std::size_t>(at)];
            if (queued[static_cast<std::size_t>(j)] != 0) continue;
            queued[static_cast<std::size_t>(j)] = 1;
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
    Search(const TurnProblem& problem, int most_visited, const TurnProblem::Turns& turns)
        : problem_(problem),
          most_visited_(most_visited),
          start_(turns),
          best_(turns),
          cover_(problem, turns) {}

    SearchResult run() {
        explore();
        SearchResult result;
        result.change = best_change_;
        result.bound = std::min(best_change_, open_bound_);
        result.proved = result.bound >= best_change_ - kGain;
        result.visited = visited_;
        return result;
    }
    const TurnProblem::Turns& best() const { return best_; }

  private:
    bool hopeless() const { return cover_.change() >= best_change_ - kGain; }

    /// Solves, drops or divides the subproblem of the cover's present limits.
    void explore() {
        ++visited_;
        cover_.minimize();
        if (hopeless()) return;
        const std::vector<int> torn = try_both_copies();
        if (torn.empty() || hopeless()) return;
        if (visited_ >= most_visited_) {
            open_bound_ = std::min(open_bound_, cover_.change());
            return;
        }
        const int vertex = widest(torn);
        const int first = cover_.turn(vertex), second = cover_.opposite_turn(vertex);
        const int middle = std::min(first, second) + std::abs(first - second) / 2;
        const bool low_first = best_[static_cast<std::size_t>(vertex)] <= middle;
        for (const bool low : {low_first, !low_first}) {
            const TurnCover::Mark mark = cover_.mark();
            cover_.confine(vertex, low ? cover_.lower(vertex) : middle + 1,
                           low ? middle : cover_.upper(vertex));
            explore();
            cover_.return_to(mark);
        }
    }

    /// Takes t, then t', as turns and polishes them; returns the vertices where the two differ.
    std::vector<int> try_both_copies() {
        std::vector<int> moved = cover_.moved();
        std::sort(moved.begin(), moved.end());
        moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
        std::vector<int> torn;
        for (const int vertex : moved) {
            if (cover_.turn(vertex) != cover_.opposite_turn(vertex)) torn.push_back(vertex);
        }
        for (const bool opposite : {false, true}) {
            TurnProblem::Turns trial = start_;
            double change = 0;
            for (const int vertex : moved) {
                const int turn = opposite ? cover_.opposite_turn(vertex) : cover_.turn(vertex);
                change += problem_.change(trial, vertex, turn);
                trial[static_cast<std::size_t>(vertex)] = turn;
            }
            if (!torn.empty()) change += polish_vertices(problem_, moved, trial);
            if (change < best_change_ - kGain) {
                best_change_ = change;
                best_ = std::move(trial);
            }
            if (torn.empty()) break;
        }
        return torn;
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
            const auto v = static_cast<std::size_t>(vertex);
            for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
                weight += tear(rings.neighbors[static_cast<std::size_t>(at)]) != 0 ? 1 : 0;
            }
            if (weight <= most) continue;
            most = weight;
            best = vertex;
        }
        return best;
    }

    const TurnProblem& problem_;
    int most_visited_;
    TurnProblem::Turns start_, best_;
    double best_change_ = 0;
    double open_bound_ = std::numeric_limits<double>::infinity();
    int visited_ = 0;
    TurnCover cover_;
};

}  // namespace

SearchResult search_turns(const TurnProblem& problem, int most_visited, TurnProblem::Turns& turns) {
    Search search(problem, most_visited, turns);
    const SearchResult result = search.run();
    turns = search.best();
    return result;
}

}  // namespace mscomp
