// SPDX-License-Identifier: MIT
#include "turn_cover.h"

#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

// One turn changes an edge by up to (2π)² = 39: less is rounding.
constexpr double kLeastGain = 1e-9;
constexpr double kRounding = 1e-12;
constexpr double kTurnSquared = kTurn * kTurn;

}  // namespace

TurnCover::TurnCover(const TurnProblem& problem, const Turns& start)
    : problem_(problem),
      rings_(problem.graph().rings),
      turn_(2 * start.size()),
      value_(2 * start.size()),
      limits_(start.size()),
      is_watched_(start.size(), 0),
      is_open_(2 * start.size(), 0),
      excess_(2 * start.size(), 0.0),
      flow_(2 * rings_.neighbors.size(), 0.0),
      level_(2 * start.size(), 0),
      next_(2 * start.size(), 0) {
    for (const int root : problem.graph().roots) {
        limits_[at(root)] = {0, 0};
    }
    for (std::size_t i = 0; i < start.size(); ++i) {
        turn_[2 * i] = turn_[2 * i + 1] = start[i];
        value_[2 * i] = problem.angle(static_cast<int>(i)) + kTurn * start[i];
        value_[2 * i + 1] = -value_[2 * i];
    }
    // Down is up seen from the other copy.
    for (std::size_t node = 0; node < turn_.size(); ++node) {
        open(node);
        if (excess_[node] > kRounding) watch(static_cast<int>(node / 2));
    }
    forget_flow();
}

std::size_t TurnCover::head(std::size_t place, std::size_t tail) const {
    const std::size_t turned = problem_.cosines()[place] < 0 ? 1 : 0;
    return 2 * at(rings_.neighbors[place]) + ((tail & 1) ^ turned);
}

// Moving X by y and Y by z turns, y and z in {0, 1}, costs α y + β z - w y z more, with
// α = 4π (X - c Y) + 4π², β likewise and w = 8π² c. Written as p y (1 - z) + q z (1 - y)
// + (α - p) y + (β - q) z with p + q = w the first two are arcs. Any p in [0, w] will do; with
// this one the rest is negative only if the edge itself has something to gain, and is shared.
double TurnCover::capacity(std::size_t place, std::size_t tail, std::size_t head) const {
    const double c = std::abs(problem_.cosines()[place]);
    const double weight = 2 * kTurnSquared * c;
    const double difference = direction_ * (value_[tail] - value_[head]);
    return std::clamp(0.5 * weight + kTurn * (1 + c) * difference, 0.0, weight);
}

void TurnCover::open(std::size_t node) {
    is_open_[node] = 1;
    opened_.push_back(node);
    const std::size_t vertex = node / 2;
    const int step = (node & 1) == 0 ? direction_ : -direction_;
    const int moved = turn_[node] + step;
    if (moved < limits_[vertex].lower || moved > limits_[vertex].upper) {
        excess_[node] = -std::numeric_limits<double>::infinity();  // may not move
        set_level_of_opened(node);
        return;
    }
    double cost = 0;
    for (int entry = rings_.offsets[vertex]; entry < rings_.offsets[vertex + 1]; ++entry) {
        const auto place = at(entry);
        const std::size_t other = head(place, node);
        const double c = std::abs(problem_.cosines()[place]);
        const double alone =
            2 * kTurn * direction_ * (value_[node] - c * value_[other]) + kTurnSquared;
        cost += alone - capacity(place, node, other);
    }
    excess_[node] = -cost;
    set_level_of_opened(node);
}

void TurnCover::set_level_of_opened(std::size_t node) {
    level_[node] = excess_[node] < -kRounding ? 1 : 2;
    next_[node] = rings_.offsets[node / 2];
    if (level_[node] < static_cast<int>(at_level_.size())) {
        ++at_level_[at(level_[node])];
    }
}

double TurnCover::room(std::size_t place, std::size_t tail, std::size_t head) const {
    return capacity(place, tail, head) - flow_[2 * place + (tail & 1)];
}

/// Distances to the nearest sink over arcs with room, counted over opened nodes; a node that is not
/// open may be a sink.
void TurnCover::measure_levels() {
    queue_.clear();
    std::fill(at_level_.begin(), at_level_.end(), 0);
    at_level_.resize(opened_.size() + 4, 0);
    std::vector<std::size_t> at_border;
    for (const std::size_t node : opened_) {
        next_[node] = rings_.offsets[node / 2];
        level_[node] = kUnreachable;
        if (excess_[node] < -kRounding) {
            level_[node] = 1;
            queue_.push_back(node);
            continue;
        }
        for (int entry = rings_.offsets[node / 2]; entry < rings_.offsets[node / 2 + 1]; ++entry) {
            const auto place = at(entry);
            const std::size_t to = head(place, node);
            if (is_open_[to] != 0 || room(place, node, to) <= kRounding) continue;
            at_border.push_back(node);
            break;
        }
    }
    std::size_t nearest_end = queue_.size();
    for (std::size_t first = 0; first < queue_.size() || !at_border.empty(); ++first) {
        if (first == nearest_end && !at_border.empty()) {
            for (const std::size_t node : at_border) {
                if (level_[node] != kUnreachable) continue;
                level_[node] = 2;
                queue_.push_back(node);
            }
            at_border.clear();
            if (first == queue_.size()) break;
        }
        const std::size_t node = queue_[first];
        for (int entry = rings_.offsets[node / 2]; entry < rings_.offsets[node / 2 + 1]; ++entry) {
            const auto place = at(entry);
            const std::size_t from = head(place, node);
            if (is_open_[from] == 0 || level_[from] != kUnreachable) continue;
            const auto forth = at(problem_.graph().reverse[place]);
            if (room(forth, from, node) <= kRounding) continue;
            level_[from] = level_[node] + 1;
            queue_.push_back(from);
        }
    }
    for (const std::size_t node : queue_) ++at_level_[at(level_[node])];
    effort_ += static_cast<std::int64_t>(opened_.size());
    lifts_ = 0;
}

/// One more than the lowest neighbour that has room for more.
void TurnCover::lift(std::size_t node) {
    const int before = level_[node];
    int lowest = kUnreachable;
    for (int entry = rings_.offsets[node / 2]; entry < rings_.offsets[node / 2 + 1]; ++entry) {
        const auto place = at(entry);
        const std::size_t to = head(place, node);
        if (room(place, node, to) <= kRounding) continue;
        if (is_open_[to] == 0) open(to);
        lowest = std::min(lowest, level_[to]);
    }
    level_[node] = lowest < kUnreachable ? lowest + 1 : kUnreachable;
    next_[node] = rings_.offsets[node / 2];
    ++lifts_;
    at_level_.resize(std::max(at_level_.size(), opened_.size() + 4), 0);
    if (level_[node] < kUnreachable) ++at_level_[at(level_[node])];
    // A level without nodes cuts off all above it. Nodes that are not open are at 1 or 2.
    if (--at_level_[at(before)] > 0 || before < 3) return;
    for (const std::size_t other : opened_) {
        if (level_[other] <= before || level_[other] == kUnreachable) continue;
        --at_level_[at(level_[other])];
        level_[other] = kUnreachable;
    }
}

/// Passes the excess of a node on to neighbours nearer to a sink, as long as there are any.
void TurnCover::discharge(std::size_t node) {
    const int end = rings_.offsets[node / 2 + 1];
    while (excess_[node] > kRounding && level_[node] != kUnreachable) {
        ++effort_;
        for (int& entry = next_[node]; entry < end && excess_[node] > kRounding; ++entry) {
            const auto place = at(entry);
            const std::size_t to = head(place, node);
            const double free = room(place, node, to);
            if (free <= kRounding) continue;
            if (is_open_[to] == 0) open(to);
            if (level_[node] != level_[to] + 1) continue;
            const double amount = std::min(excess_[node], free);
            const bool was_active = excess_[to] > kRounding;
            const auto back = at(problem_.graph().reverse[place]);
            flow_[2 * place + (node & 1)] += amount;
            flow_[2 * back + (to & 1)] -= amount;
            excess_[node] -= amount;
            excess_[to] += amount;
            if (!was_active && excess_[to] > kRounding) active_.push_back(to);
        }
        if (excess_[node] > kRounding) lift(node);
    }
}

/// Sends excess to nodes that cost something to move (push and relabel, first in, first out).
/// \return what is left: the gain of moving the nodes that are reached from it
double TurnCover::maximum_flow() {
    active_ = sources_;
    std::fill(at_level_.begin(), at_level_.end(), 0);
    at_level_.resize(std::max(at_level_.size(), opened_.size() + 4), 0);
    for (const std::size_t node : opened_) ++at_level_[at(level_[node])];
    lifts_ = 0;
    for (std::size_t first = 0; first < active_.size(); ++first) {
        discharge(active_[first]);
        if (lifts_ > opened_.size()) measure_levels();
    }
    double gain = 0;
    queue_.clear();
    for (const std::size_t node : opened_) {
        if (excess_[node] <= kRounding) continue;
        gain += excess_[node];
        queue_.push_back(node);
    }
    return gain;
}

/// The nodes that those in the queue can pass something on to, added to it.
void TurnCover::collect_reached() {
    for (const std::size_t node : opened_) level_[node] = 0;
    for (const std::size_t node : queue_) level_[node] = 1;
    for (std::size_t first = 0; first < queue_.size(); ++first) {
        const std::size_t node = queue_[first];
        for (int entry = rings_.offsets[node / 2]; entry < rings_.offsets[node / 2 + 1]; ++entry) {
            const auto place = at(entry);
            const std::size_t to = head(place, node);
            if (room(place, node, to) <= kRounding || level_[to] == 1) continue;
            level_[to] = 1;
            queue_.push_back(to);
        }
    }
}

void TurnCover::forget_flow() {
    effort_ += static_cast<std::int64_t>(opened_.size());
    for (const std::size_t node : opened_) {
        is_open_[node] = 0;
        const std::size_t vertex = node / 2;
        for (int entry = rings_.offsets[vertex]; entry < rings_.offsets[vertex + 1]; ++entry) {
            flow_[2 * at(entry) + (node & 1)] = 0;
        }
    }
    opened_.clear();
}

bool TurnCover::move_best_set(int direction) {
    direction_ = direction;
    sources_.clear();
    for (const int vertex : watched_) {
        for (std::size_t copy = 0; copy < 2; ++copy) {
            const std::size_t node = 2 * at(vertex) + copy;
            open(node);
            if (excess_[node] > kRounding) sources_.push_back(node);
        }
    }
    const double gain = sources_.empty() ? 0 : maximum_flow();
    if (gain <= kLeastGain) {
        forget_flow();
        return false;
    }
    collect_reached();
    forget_flow();
    for (const std::size_t node : queue_) {
        set_turn(node, turn_[node] + ((node & 1) == 0 ? direction : -direction));
    }
    change_ -= 0.5 * gain;
    return true;
}

void TurnCover::minimize() {
    for (bool moved = true; moved;) {
        moved = false;
        while (move_best_set(1)) moved = true;
        while (move_best_set(-1)) moved = true;
    }
}

void TurnCover::set_turn(std::size_t node, int turn) {
    const auto vertex = static_cast<int>(node / 2);
    steps_.push_back({static_cast<int>(node), turn_[node]});
    moved_.push_back(vertex);
    turn_[node] = turn;
    const double value = problem_.angle(vertex) + kTurn * turn;
    value_[node] = (node & 1) == 0 ? value : -value;
    watch_ring(vertex);
}

void TurnCover::watch(int vertex) {
    char& known = is_watched_[at(vertex)];
    if (known != 0) return;
    known = 1;
    watched_.push_back(vertex);
}

void TurnCover::watch_ring(int vertex) {
    watch(vertex);
    const auto v = at(vertex);
    for (int entry = rings_.offsets[v]; entry < rings_.offsets[v + 1]; ++entry) {
        watch(rings_.neighbors[at(entry)]);
    }
}

/// Half the energy of the arcs that leave a node.
double TurnCover::local_energy(std::size_t node) const {
    const std::size_t vertex = node / 2;
    double sum = 0;
    for (int entry = rings_.offsets[vertex]; entry < rings_.offsets[vertex + 1]; ++entry) {
        const auto place = at(entry);
        const double x = value_[node], y = value_[head(place, node)];
        sum += 0.5 * (x * x + y * y - 2 * std::abs(problem_.cosines()[place]) * x * y);
    }
    return sum;
}

void TurnCover::confine(int vertex, int lower, int upper) {
    const auto v = at(vertex);
    confined_.push_back({vertex, limits_[v]});
    limits_[v] = {std::max(lower, limits_[v].lower), std::min(upper, limits_[v].upper)};
    for (const std::size_t node : {2 * v, 2 * v + 1}) {
        const int turn = std::clamp(turn_[node], limits_[v].lower, limits_[v].upper);
        if (turn == turn_[node]) continue;
        change_ -= local_energy(node);
        set_turn(node, turn);
        change_ += local_energy(node);
    }
}

void TurnCover::return_to(const Mark& mark) {
    while (steps_.size() > mark.steps) {
        const auto [node, turn] = steps_.back();
        steps_.pop_back();
        moved_.pop_back();
        const auto n = at(node);
        turn_[n] = turn;
        const double value = problem_.angle(node / 2) + kTurn * turn;
        value_[n] = (node & 1) == 0 ? value : -value;
    }
    while (confined_.size() > mark.confined) {
        limits_[at(confined_.back().vertex)] = confined_.back().limits;
        confined_.pop_back();
    }
    while (watched_.size() > mark.watched) {
        is_watched_[at(watched_.back())] = 0;
        watched_.pop_back();
    }
    change_ = mark.change;
}

}  // namespace mscomp
