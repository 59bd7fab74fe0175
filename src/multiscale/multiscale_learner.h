// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "multiscale/alternating_squares.h"
#include "multiscale/cross_validation.h"
#include "multiscale/multiscale_model.h"
#include "multiscale/space_descent.h"
#include "multiscale/training_pool.h"

namespace mscomp {

/// What learning needs of the place of a model.
struct LearnerPlace {
    const TriangleMesh& reference;
    const std::string& weights;  // edge weights of the features
    DistanceRows& distances;
};

/// Trains a multiscale model: an epoch is a round of alternating least squares, or later some steps
/// of descent in space. Both are functions of the components before, the shapes, the seed, their
/// number, and in space of the SpaceState of the model.
class MultiscaleLearner final : public Learner {
  public:
    /// Borrows everything but `train`.
    MultiscaleLearner(MultiscaleModel& model, const MultiscaleSettings& settings,
                      const TrainConfig& config, const LearnerPlace& place, const ShapeSet& shapes,
                      std::span<const int> train);

    std::vector<std::string> term_names() const override { return {"reconstruction", "space"}; }
    void start() override;
    void start_from(const GivenComponents& given) override;
    std::vector<std::string> notes() const override { return notes_; }
    void resume(const TrainingState& state) override { state_ = state; }
    const TrainingState& state() const override { return state_; }
    EpochReport run_epoch() override;
    bool is_over() const override { return state_.epoch >= config_.epochs; }
    CodeTable codes() override;

  private:
    Choices chosen();
    void begin(BallComponents components, std::vector<int> parents);
    TrainingPool& pool();
    EpochReport alternate();
    EpochReport descend();
    SpaceDescent::Report descend_from(BallComponents& components, SpaceState& state) const;

    MultiscaleModel& model_;
    const MultiscaleSettings& settings_;
    const TrainConfig& config_;
    LearnerPlace place_;
    const ShapeSet& shapes_;
    std::vector<int> train_;
    std::optional<Mirror> mirror_;
    std::optional<TrainingPool> pool_;  // made when first needed
    std::vector<std::string> notes_;    // what start() decided
    AlternatingSquares squares_;
    std::unique_ptr<SpaceDescent> descent_;  // made when it begins
    TrainingState state_;
};

}  // namespace mscomp
