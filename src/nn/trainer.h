// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "learning/mixed_features.h"
#include "mscomp/model/config.h"
#include "mscomp/model/learned_model.h"
#include "nn/batch_loader.h"
#include "nn/model.h"

namespace mscomp::nn {

/// Shapes in an epoch of training on `shapes` of a mesh of `vertices`: fewer than
/// TrainConfig::fill_up_to and than fill_below are filled up by mixed ones; beyond 200,000 vertices
/// only as far as lanes are there anyway, since memory is what such meshes lack.
int epoch_size(const TrainConfig& config, int shapes, int vertices);

/// Trains a model of any kind. A step is a function of the parameters, the moments,
/// the centres, seed and step number and of nothing else: saved, loaded and continued gives the
/// same bits as never stopped, for any number of threads.
class Trainer {
  public:
    /// Borrows everything. `shapes` are those to train on (at least one), joined by mixed ones if
    /// they are few. While they all fit into one batch they stay there as long as they are the
    /// same; the next batch is gathered during a step.
    Trainer(Model<float>& model, const TrainConfig& config, const ScaledFeatures& features,
            std::span<const int> shapes);
    /// `features` (N,V,9) in memory, scaled already.
    Trainer(Model<float>& model, const TrainConfig& config, std::span<const float> features,
            std::span<const int> shapes);

    /// Parameters as TrainConfig::start says; state becomes zero.
    void start();
    /// Goes on from a saved state, whose parameters the model already holds.
    void resume(const TrainingState& state) { state_ = state; }
    const TrainingState& state() const { return state_; }

    /// One pass over the shapes in batches. Throws DivergenceError before the update of a step
    /// whose loss or gradient is not finite, when parameters are those of the step before, and
    /// after an epoch that went astray (kAstray).
    EpochReport run_epoch();

    /// Codes of the training shapes. Throws DivergenceError where the parameters or their moments
    /// are not finite, or the model went astray.
    CodeTable codes();

    /// A model went astray if its reconstruction error is above so many times that of no model at
    /// all on every level, and above so many times that of the first step. Whatever trains stays
    /// far below: weights that explain nothing have the error of none, and descent lowers it.
    static constexpr double kAstray = 4;

    /// No epochs are left, or a plateau has been reached and counts (TrainConfig::plateau_epochs).
    bool is_over() const;

  private:
    Trainer(Model<float>& model, const TrainConfig& config, std::unique_ptr<MemoryFeatures> memory,
            std::span<const int> shapes);
    std::vector<int> shapes_of_epoch(std::int64_t epoch) const;
    std::vector<int> order_of_epoch(std::int64_t epoch) const;
    void watch_plateau(double error);
    void load(std::span<const int> batch);
    void step(EpochReport& report);
    void require_finite_loss(float loss);
    void require_finite_gradients();
    void require_finite_parameters();
    [[noreturn]] void fail_after_update(const std::string& what) const;
    void require_not_astray(double error, double energy) const;

    Model<float>& model_;
    const TrainConfig& config_;
    std::unique_ptr<MemoryFeatures> memory_;
    std::unique_ptr<MixedFeatures> mixed_;  // none if there are shapes enough
    ScaledFeatures features_;
    std::vector<int> shapes_;
    BatchLoader loader_;
    std::vector<int> loaded_;
    double energy_ = 0;  // Model::input_energy of the loaded batch
    TrainingState state_;
};

}  // namespace mscomp::nn
