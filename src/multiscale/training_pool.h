// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "learning/mixed_features.h"
#include "mscomp/acap/mirrored_features.h"
#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// The shapes that components are fitted to: the training shapes, their mirror images where the
/// reference is symmetric, and locally mixed ones of all these.
class TrainingPool {
  public:
    struct Options {
        int fill_up_to = 0;  // as many shapes as this, by mixed ones
        std::uint64_t seed = 0;
        double between = 0;  // part of the patches of mixed shapes that follow two
    };
    /// Borrows the shapes, the mirror (null: none) and the scale, and the distances for so long.
    TrainingPool(const ShapeFeatures& shapes, std::span<const int> train, const Mirror* mirror,
                 DistanceRows& distances, const MetricScale& scale, const Options& options);

    int shape_count() const { return static_cast<int>(real_.size()) + mixed_count_; }
    /// Of round `round`, in which four of the mixed shapes are others than in the one before: a
    /// function of the seed and the round. Valid until the next call.
    const MetricRows& rows(std::int64_t round);

  private:
    int mixed_shape(std::int64_t place, std::int64_t round) const;

    const MetricScale& scale_;
    std::optional<MirroredFeatures> mirrored_;
    std::vector<int> real_;  // by number in source_
    int mixed_count_ = 0;
    std::unique_ptr<MixedFeatures> mixed_;   // none if nothing is mixed
    const ShapeFeatures* source_ = nullptr;  // the last of those above
    std::vector<int> gathered_;              // what rows_ has
    std::optional<MetricRows> rows_;
};

}  // namespace mscomp
