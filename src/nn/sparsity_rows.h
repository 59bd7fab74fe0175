// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/index.h"
#include "mscomp/nn/config.h"
#include "nn/active_vertices.h"

namespace mscomp::nn {

/// Where group sparsity acts around a centre: Lambda_ik of [A] eq. 3, 0 nearer than the reach of
/// the centre and 1 from it on, or the clipped ramp of the AAAI-18 predecessor.
struct SparsityRow {
    std::span<const double> distances;  // (V) from the centre
    double from = 0, to = 0;            // weights rise from 0 at `from` to 1 at `to`

    double weight(int vertex) const {
        const double distance = distances[at(vertex)];
        if (distance >= to) return 1;
        return distance <= from ? 0 : (distance - from) / (to - from);
    }
    /// Whether the component may act here at all without full penalty.
    bool is_free(int vertex) const { return weight(vertex) < 1; }
};

enum class CenterRule {
    follow,  // always the longest vertex, as in the papers
    settle   // moves to the longest vertex only where that lowers the penalty of the component
};

/// The centres of the components of one level and the penalty around them. The reach of a centre is
/// the sparsity range, or less where more than LevelConfig::max_support of the vertices are nearer.
///
/// Under `follow` a component whose longest vertex jumps is suddenly free elsewhere and punished
/// where it lives; together with exact zeros that destroys it. `settle` never raises the penalty.
class SparsityRows {
  public:
    /// Borrows `distances` and `supports`; without supports every vertex acts.
    SparsityRows(DistanceRows& distances, const LevelConfig& level, CenterRule rule,
                 const LevelSupports* supports = nullptr);

    /// Updates the centres for component weights (rows,V,9) and returns one row for each.
    template <class T>
    const std::vector<SparsityRow>& focus(std::span<const T> component_weights);

    std::int64_t row_count() const { return static_cast<std::int64_t>(rows_.size()); }
    /// Vertices that act in component `row`, rising; its weights are zero elsewhere.
    std::span<const int> acting(std::int64_t row) const;
    /// |C_k,i| of them at the last focus.
    std::span<const double> lengths(std::int64_t row) const {
        const auto i = at(row);
        return std::span(lengths_).subspan(first_length_[i],
                                           first_length_[i + 1] - first_length_[i]);
    }

    /// Centres of the last focus or as set; -1 where there is none yet.
    const std::vector<int>& centers() const { return centers_; }
    void set_centers(std::vector<int> centers) { centers_ = std::move(centers); }

    SparsityRow row(int center);

  private:
    double penalty(const SparsityRow& around, std::int64_t row) const;

    DistanceRows& distances_;
    LevelConfig level_;
    CenterRule rule_;
    const LevelSupports* supports_;
    std::vector<int> all_vertices_;  // where there are no supports
    std::vector<int> centers_;
    std::vector<SparsityRow> rows_;
    std::vector<double> lengths_;            // of the acting vertices of every row
    std::vector<std::size_t> first_length_;  // (rows+1) into them
    std::vector<int> longest_;               // (rows) at the last focus
    std::vector<int> prepared_;              // vertices whose distances the last focus asked for
    std::vector<SparsityRow> candidates_;
    std::unordered_map<int, double> reaches_;  // by centre
};

}  // namespace mscomp::nn
