// SPDX-License-Identifier: MIT
#include "neighbor_starts.h"

#include <algorithm>
#include <utility>

#include "acap/shape_extraction.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

constexpr int kRounds = 3;

bool is_proved(const ConsistencySummary& summary) {
    return summary.energy <= summary.lower_bound + 1e-9 * (1 + summary.lower_bound);
}

class NeighborStarts {
  public:
    NeighborStarts(const ConsistencyGraph& graph, FeatureRows& rows,
                   std::vector<ConsistencySummary>& summaries, const StartTrial& trial)
        : graph_(graph),
          rows_(rows),
          summaries_(summaries),
          trial_(trial),
          width_(at(graph.rings.vertex_count()) * kFeatureDim),
          changed_(summaries.size(), 0),
          tried_(summaries.size(), -1) {}

    /// Step number `step` of shape `index`: only this shape is changed.
    void try_neighbors(int index, int step) {
        const auto n = at(index);
        const int last_tried = std::exchange(tried_[n], step);
        for (const int neighbor : {index - 1, index + 1}) {
            if (neighbor < 0 || neighbor >= static_cast<int>(summaries_.size())) continue;
            // What stands there since the last time was no help then.
            if (changed_[at(neighbor)] <= last_tried) continue;
            if (is_proved(summaries_[n])) return;
            try_start(index, neighbor, step);
        }
    }
    bool has_changed_since(int step) const {
        return std::any_of(changed_.begin(), changed_.end(),
                           [&](int changed) { return changed >= step; });
    }

  private:
    void try_start(int index, int neighbor, int step) {
        const auto n = at(index);
        std::vector<float> row(width_);
        rows_.get_features(neighbor, row);
        const std::vector<Eigen::Vector3d> start = rotation_vectors_of(row);
        rows_.get_features(index, row);
        std::vector<Eigen::Vector3d> rotation_vectors = rotation_vectors_of(row);
        if (!trial_(graph_, start, rotation_vectors, summaries_[n])) return;
        store_rotation_vectors(rotation_vectors, row);
        rows_.put_features(index, row);
        changed_[n] = step;
    }

    const ConsistencyGraph& graph_;
    FeatureRows& rows_;
    std::vector<ConsistencySummary>& summaries_;
    const StartTrial& trial_;
    std::size_t width_;
    std::vector<int> changed_, tried_;  // (N) step of the last time
};

}  // namespace

void improve_from_neighbors(const ConsistencyGraph& graph, FeatureRows& rows,
                            std::vector<ConsistencySummary>& summaries,
                            const std::function<void()>& after_each, const StartTrial& try_start) {
    NeighborStarts starts(graph, rows, summaries, try_start);
    const auto count = static_cast<std::int64_t>(summaries.size());
    for (int round = 0; round < kRounds; ++round) {
        for (const int parity : {0, 1}) {
            const int step = 2 * round + parity + 1;
            parallel_for((count + 1 - parity) / 2, [&](std::int64_t i) {
                starts.try_neighbors(static_cast<int>(2 * i + parity), step);
                after_each();
            });
        }
        if (!starts.has_changed_since(2 * round + 1)) return;
    }
}

}  // namespace mscomp
