// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace mscomp {

/// Minimises Σ_i cost_i y_i + Σ_(i,j) w_ij |y_i - y_j| over y in {0, 1}^n, w >= 0, exactly (up to
/// rounding), as a maximum flow by Dinic's method.
class MinimumCut {
  public:
    explicit MinimumCut(int node_count);

    void add_cost(int node, double cost) { cost_[static_cast<std::size_t>(node)] += cost; }
    void add_edge(int i, int j, double weight);
    /// (n) the minimiser with the fewest ones.
    std::vector<char> solve();

  private:
    struct Arc {
        int to;
        double capacity;
    };
    void add_arcs(int from, int to, double forward, double backward);
    bool level_nodes();
    double push_path();

    int node_count_;
    std::vector<double> cost_;
    std::vector<Arc> arcs_;               // arc k and its reverse k ^ 1
    std::vector<std::vector<int>> from_;  // arcs that leave a node
    std::vector<int> level_;
    std::vector<std::size_t> next_;
    double smallest_ = 0;  // capacities at or below are rounding
};

}  // namespace mscomp
