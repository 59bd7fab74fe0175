// SPDX-License-Identifier: MIT
#include "minimum_cut.h"

#include <algorithm>
#include <cmath>

namespace mscomp {

MinimumCut::MinimumCut(int node_count)
    : node_count_(node_count),
      cost_(static_cast<std::size_t>(node_count), 0.0),
      from_(static_cast<std::size_t>(node_count) + 2) {}

void MinimumCut::add_arcs(int from, int to, double forward, double backward) {
    from_[static_cast<std::size_t>(from)].push_back(static_cast<int>(arcs_.size()));
    arcs_.push_back({to, forward});
    from_[static_cast<std::size_t>(to)].push_back(static_cast<int>(arcs_.size()));
    arcs_.push_back({from, backward});
}

void MinimumCut::add_edge(int i, int j, double weight) { add_arcs(i, j, weight, weight); }

bool MinimumCut::level_nodes() {
    const int source = node_count_, sink = node_count_ + 1;
    level_.assign(from_.size(), -1);
    level_[static_cast<std::size_t>(source)] = 0;
    std::vector<int> queue{source};
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const auto node = static_cast<std::size_t>(queue[head]);
        for (const int index : from_[node]) {
            const Arc& arc = arcs_[static_cast<std::size_t>(index)];
            const auto to = static_cast<std::size_t>(arc.to);
            if (level_[to] >= 0 || arc.capacity <= smallest_) continue;
            level_[to] = level_[node] + 1;
            queue.push_back(arc.to);
        }
    }
    return level_[static_cast<std::size_t>(sink)] >= 0;
}

/// Sends what one shortest path can take; 0 when the level graph is blocked.
double MinimumCut::push_path() {
    const int source = node_count_, sink = node_count_ + 1;
    std::vector<int> path;
    int at = source;
    while (at != sink) {
        const auto node = static_cast<std::size_t>(at);
        bool advanced = false;
        for (std::size_t& next = next_[node]; next < from_[node].size(); ++next) {
            const int index = from_[node][next];
            const Arc& arc = arcs_[static_cast<std::size_t>(index)];
            if (arc.capacity > smallest_ &&
                level_[static_cast<std::size_t>(arc.to)] == level_[node] + 1) {
                path.push_back(index);
                at = arc.to;
                advanced = true;
                break;
            }
        }
        if (advanced) continue;
        if (path.empty()) return 0;
        const auto back = static_cast<std::size_t>(path.back());
        path.pop_back();
        at = arcs_[back ^ 1U].to;
        ++next_[static_cast<std::size_t>(at)];
    }
    double amount = arcs_[static_cast<std::size_t>(path.front())].capacity;
    for (const int index : path) {
        amount = std::min(amount, arcs_[static_cast<std::size_t>(index)].capacity);
    }
    for (const int index : path) {
        arcs_[static_cast<std::size_t>(index)].capacity -= amount;
        arcs_[static_cast<std::size_t>(index) ^ 1U].capacity += amount;
    }
    return amount;
}

std::vector<char> MinimumCut::solve() {
    const int source = node_count_, sink = node_count_ + 1;
    double largest = 0;
    for (int node = 0; node < node_count_; ++node) {
        const double cost = cost_[static_cast<std::size_t>(node)];
        // A node on the source's side is 1: a negative cost is lost if it is cut off from there.
        if (cost < 0) add_arcs(source, node, -cost, 0);
        if (cost > 0) add_arcs(node, sink, cost, 0);
    }
    for (const Arc& arc : arcs_) largest = std::max(largest, arc.capacity);
    smallest_ = 1e-13 * largest;
    while (level_nodes()) {
        next_.assign(from_.size(), 0);
        while (push_path() > 0) {
        }
    }
    std::vector<char> ones(static_cast<std::size_t>(node_count_));
    for (std::size_t node = 0; node < ones.size(); ++node) ones[node] = level_[node] >= 0 ? 1 : 0;
    return ones;
}

}  // namespace mscomp
