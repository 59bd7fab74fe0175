// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mscomp/nn/config.h"
#include "mscomp/nn/model_file.h"
#include "mscomp/nn/stacked_model.h"

namespace mscomp::nn {

/// Means over the steps of one epoch.
struct EpochReport {
    TrainingState state;
    double total = 0;
    std::vector<AutoencoderTerms> terms;  // per level, summed over its autoencoders, unweighted
    double learning_rate = 0;
    double step_ms = 0;
};

/// Trains a stacked model on scaled features. A step is a function of the parameters, the moments,
/// the centres, seed and step number and of nothing else: saved, loaded and continued gives the
/// same bits as never stopped, for any number of threads.
class Trainer {
  public:
    /// Borrows everything. `features` (N,V,9) scaled, `shapes` those to train on (at least one).
    Trainer(StackedModel<float>& model, const Config& config, std::span<const float> features,
            std::span<const int> shapes);

    /// Parameters as Config::train.start says; state becomes zero.
    void start();
    /// Goes on from a saved state, whose parameters the model already holds.
    void resume(const TrainingState& state) { state_ = state; }
    const TrainingState& state() const { return state_; }

    /// One pass over the shapes in batches. Throws NumericalError before the update of a step whose
    /// loss or gradient is not finite; parameters are then those of the step before.
    EpochReport run_epoch();

    /// Codes of the training shapes per level, (n, A*K).
    std::vector<std::vector<float>> codes();

  private:
    void step(std::span<const int> batch, EpochReport& report);
    void require_finite(float loss);

    StackedModel<float>& model_;
    const Config& config_;
    std::span<const float> features_;
    std::vector<int> shapes_;
    std::vector<int> loaded_;
    TrainingState state_;
};

/// Options a model gets for training under `config` on `shapes` shapes.
StackedModel<float>::Options training_options(const Config& config, int shapes);

}  // namespace mscomp::nn
