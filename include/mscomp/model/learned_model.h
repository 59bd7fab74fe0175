// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/model/shape_model.h"

namespace mscomp {

class SafetensorsFile;
struct GivenComponents;
class StoredArrays;

/// How far training has come.
struct TrainingState {
    std::int64_t epoch = 0;  // epochs done
    std::int64_t step = 0;   // updates done
    double total = 0;        // total loss of the last step
    /// Mean error of the last whole plateau window (0: none yet), the sum and the epochs since
    /// then.
    double window_mean = 0, window_sum = 0;
    std::int64_t window_epochs = 0;
    bool is_plateau = false;  // the last window gained too little: training is over
    /// Factor of the learning rate, halved each time training diverged.
    double rate_factor = 1;
    double first_error = 0;  // reconstruction error of the first step; 0: none yet
};

/// Means over the steps of one epoch.
struct EpochReport {
    TrainingState state;
    double total = 0;
    std::vector<double> terms;  // in the order of Learner::term_names(), unweighted
    double learning_rate = 0;
    double step_ms = 0;
    double touched = 1;  // share of the vertices that an autoencoder of the last level touches
};

/// The training of one model, epoch by epoch: a function of the data, the configuration and the
/// saved state alone, so that saved, loaded and continued gives the same bits as never stopped.
class Learner {
  public:
    Learner() = default;
    Learner(const Learner&) = delete;
    Learner& operator=(const Learner&) = delete;
    virtual ~Learner() = default;

    /// What the terms of the loss are called.
    virtual std::vector<std::string> term_names() const = 0;
    /// Begins anew.
    virtual void start() = 0;
    /// Begins anew with the components of another model, of which it needs nothing afterwards.
    /// Throws UsageError where the configuration is not one for these.
    virtual void start_from(const GivenComponents& given);
    /// What start() decided by itself, a sentence each, for the log.
    virtual std::vector<std::string> notes() const { return {}; }
    /// What speaks against what start() found, a sentence each, for whoever trains.
    virtual std::vector<std::string> warnings() const { return {}; }
    /// Goes on from a saved state, whose arrays the model already holds.
    virtual void resume(const TrainingState& state) = 0;
    virtual const TrainingState& state() const = 0;
    /// Throws NumericalError before anything that is not finite gets into the model,
    /// DivergenceError (divergence.h) where an earlier state and a lower rate may help.
    virtual EpochReport run_epoch() = 0;
    virtual bool is_over() const = 0;
    /// Codes of the training shapes. Throws DivergenceError for a model that is not worth saving.
    virtual CodeTable codes() = 0;
};

/// A model that learns from shapes and lives in a model file.
class LearnedModel : public ShapeModel {
  public:
    /// Borrows the shapes; `train` are those to learn from, at least one.
    virtual std::unique_ptr<Learner> learner(const ShapeSet& shapes,
                                             std::span<const int> train) = 0;
    /// Arrays that load() and further training need; borrowed until they are written.
    virtual void save(StoredArrays& arrays) const = 0;
    /// Throws CheckpointError, or InputError, where the arrays are not those of such a model.
    virtual void load(const SafetensorsFile& file) = 0;
};

}  // namespace mscomp
