// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mscomp/model/config.h"
#include "mscomp/model/learned_model.h"

namespace mscomp {

struct TrainingOptions {
    bool resume = false;  // go on from the checkpoint of the folder if there is one
    std::string title;    // first line of log.txt, behind the date: what began this
    /// What is odd about whole shapes, before anything is learnt of them; it is in log.txt, too.
    /// May be empty, as may all that follow.
    std::function<void(const std::string& sentence)> on_warning;
    /// Before the first epoch, with what is done already.
    std::function<void(const TrainingState& state)> on_begin;
    /// After every epoch; the names are those of the terms.
    std::function<void(const EpochReport& report, const std::vector<std::string>& terms)> on_epoch;
    /// Training diverged and went back to `state`, at half the rate; `what` says so for the user.
    std::function<void(const TrainingState& state, const std::string& what)> on_setback;
    /// Asked after every epoch: then the run is saved, and that is all.
    std::function<bool()> should_stop;
    /// Asked after every epoch: then the run is saved, and goes on.
    std::function<bool()> should_save;
};

struct TrainingResult {
    TrainingState state;
    bool is_stopped = false;  // should_stop said so
};

/// Whether the folder has a checkpoint to go on from.
bool has_checkpoint(const std::string& run);
/// Throws UsageError naming --force if a training that begins in the folder would replace what is
/// no run without a checkpoint, as one leaves that was killed early; with `resume`, if it would
/// replace a file that is not of a run. Undoes first what a killed process left half done.
void require_free_run(const std::string& run, bool resume, bool force);

/// Trains a model as `config` says, whose file names are absolute, in the run folder `run`, which
/// is made if it is missing: config.yaml, metrics.csv, log.txt and the checkpoint, saved together
/// at the start, then every train.checkpoint_every epochs or two minutes, and at the end. A
/// checkpoint that is there is gone on from if `resume` says so, else replaced. What a resumed run
/// may change is said by ConfigChange; the change is saved even where no epoch is left. Training
/// that diverges goes back to the last epoch that is a multiple of train.checkpoint_every, at half
/// the rate, ten times at most; then it throws NumericalError. The same bits whether it was stopped
/// or not, for any number of threads. Throws IoError at once if another process trains there,
/// UsageError (nothing to train on, a resumed run of other data or another configuration),
/// CheckpointError, IoError and what training throws.
TrainingResult train_run(const Config& config, const std::string& run,
                         const TrainingOptions& options = {});

/// How far what lies in a run folder is on the way to what `config` asks for.
enum class TrainingProgress { none, begun, finished };
struct TrainingDemand {
    Config config;
    std::string source_hash;        // of the feature file
    std::vector<int> train_shapes;  // of it
};
/// `none` where it has to be trained anew: other features or training shapes, another beginning
/// where that is a run, fewer epochs, or as ConfigChange says; `finished` only if nothing of the
/// configuration that is saved differs. Throws CheckpointError for a checkpoint that cannot be
/// read.
TrainingProgress training_progress(const std::string& run, const TrainingDemand& demand);

}  // namespace mscomp
