// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "learning/mixed_features.h"
#include "mscomp/acap/mirrored_features.h"
#include "multiscale/multiscale_model.h"

namespace mscomp {

/// Trains a multiscale model: an epoch is a round of alternating least squares. A round is a
/// function of the components before, the shapes, the seed and its number.
class MultiscaleLearner final : public Learner {
  public:
    /// Borrows everything but `train`.
    MultiscaleLearner(MultiscaleModel& model, const MultiscaleSettings& settings,
                      const TrainConfig& config, DistanceRows& distances, const ShapeSet& shapes,
                      std::span<const int> train);

    std::vector<std::string> term_names() const override { return {"reconstruction"}; }
    void start() override;
    void resume(const TrainingState& state) override { state_ = state; }
    const TrainingState& state() const override { return state_; }
    EpochReport run_epoch() override;
    bool is_over() const override;
    CodeTable codes() override;

  private:
    void gather(std::int64_t epoch);

    MultiscaleModel& model_;
    const MultiscaleSettings& settings_;
    const TrainConfig& config_;
    DistanceRows& distances_;
    const ShapeSet& shapes_;
    std::vector<int> train_;
    std::optional<Mirror> mirror_;
    std::optional<MirroredFeatures> mirrored_;
    std::optional<MixedFeatures> mixed_;
    std::vector<int> gathered_;  // shapes that rows_ has, by number in mixed_
    std::unique_ptr<MetricRows> rows_;
    TrainingState state_;
};

}  // namespace mscomp
