// SPDX-License-Identifier: MIT
#include "mscomp/run/training_run.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <optional>

#include "milestone.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "mscomp/base/paths.h"
#include "mscomp/config/config_file.h"
#include "mscomp/model/divergence.h"
#include "mscomp/run/config_change.h"
#include "mscomp/run/peak_memory.h"
#include "mscomp/run/run_folder.h"
#include "run_lock.h"
#include "starting_run.h"
#include "training_error.h"
#include "training_log.h"
#include "training_setup.h"

namespace mscomp {
namespace {

/// The earlier part of a run, whose configuration allows to go on. Throws UsageError otherwise.
ModelFile earlier_part(const std::string& run, const Config& config) {
    ModelFile earlier(checkpoint_path(run));
    const Config before = parse_config(earlier.context().config, checkpoint_path(run));
    if (config_change(before, config).may_go_on()) return earlier;
    throw UsageError(fmt::format(
        "{} was trained with another configuration (see {}); --resume may only change "
        "train.epochs, train.plateau_epochs, train.plateau_gain, train.checkpoint_every "
        "and filter",
        run, config_path(run)));
}

void require_same_features(const ModelFile& earlier, const TrainingSetup& setup,
                           const std::string& run) {
    if (earlier.context().source_hash == setup.context.source_hash) return;
    throw UsageError(
        fmt::format("{} was trained on other features than {} holds now; --resume "
                    "needs the same",
                    run, setup.config.data.features));
}

void describe(const TrainingSetup& setup, const std::string& run, LineFile& log) {
    log.append(fmt::format("{}: {} shapes ({} train), {} vertices; run folder {}",
                           setup.config.data.features, setup.features.shape_count(),
                           setup.context.train_shapes.size(), setup.features.vertex_count(), run));
    log.append(fmt::format("largest geodesic distance {:.6g} ({})", setup.context.largest_distance,
                           setup.context.largest_distance_exact ? "exact" : "lower bound"));
    const std::vector<std::string>& names = setup.features.outline().names;
    for (const FeatureExtreme& extreme : setup.scaler.extremes) {
        log.append(
            fmt::format("extreme of the training features: channel {} is {:.6g} in {} at vertex {} "
                        "(counting from 1)",
                        extreme.channel, extreme.value, names[at(extreme.shape)],
                        setup.context.places.vertex(extreme.vertex) + 1));
    }
}

/// Codes of the training shapes, and the error that the setup is to have beside them.
CodeTable codes_to_save(TrainingSetup& setup, Learner& learner) {
    CodeTable codes = learner.codes();
    setup.context.squared_error = squared_error(
        *setup.model, setup.shapes, setup.context.train_shapes, codes, setup.context.scale);
    return codes;
}

/// A run that is under way in its folder.
class Training {
  public:
    Training(const std::string& run, TrainingSetup& setup, Learner& learner, LineFile& log)
        : run_(run),
          setup_(setup),
          learner_(learner),
          log_(log),
          milestone_(run, setup.config.train.checkpoint_every, learner.state().epoch) {
        open_metrics();
    }

    /// Rows and log first, so that the checkpoint never claims more than they hold.
    void save() {
        metrics_->sync();
        const TrainingState& state = learner_.state();
        const CodeTable codes = codes_to_save(setup_, learner_);
        milestone_.before_saving(state.epoch, learner_.is_over());
        write_model(checkpoint_path(run_), *setup_.model, setup_.context, state, codes);
        note_saved();
    }
    void note_saved() {
        const TrainingState& state = learner_.state();
        milestone_.after_saving(state.epoch, learner_.is_over());
        log_.append(fmt::format("saved at epoch {}, step {}, loss {:.6g}; peak memory {:.0f} MiB",
                                state.epoch, state.step, state.total, peak_memory_mib()));
        log_.sync();
        saved_at_ = std::chrono::steady_clock::now();
    }

    /// Epochs until the end, or until `options` say stop; true if they did.
    bool go_on(const TrainingOptions& options) {
        if (options.on_begin) options.on_begin(learner_.state());
        bool is_stopped = false;
        while (!is_stopped && !learner_.is_over()) {
            try {
                is_stopped = run_epoch(options);
            } catch (const DivergenceError& error) {
                go_back(error, options);
            }
        }
        // Asked to stop, but there is nothing left to go on with.
        return is_stopped && !learner_.is_over();
    }

  private:
    /// True if `options` say stop.
    bool run_epoch(const TrainingOptions& options) {
        const EpochReport report = learner_.run_epoch();
        metrics_->append(report);
        if (options.on_epoch) options.on_epoch(report, metrics_->term_names());
        const bool is_stopped = options.should_stop && options.should_stop();
        const bool is_wanted = options.should_save && options.should_save();
        if (learner_.is_over() || milestone_.is_at(learner_.state().epoch)) {
            save();
        } else if (is_stopped || is_wanted || is_long_unsaved()) {
            save_between(is_stopped);
        }
        return is_stopped;
    }

    /// When a clock or somebody says so. What such a look at the model finds must not decide how
    /// training goes on: it is not saved then, and who stops there is left with the last milestone,
    /// at the rate that was come to.
    void save_between(bool is_stopped) {
        try {
            save();
        } catch (const DivergenceError& error) {
            log_.append(fmt::format("{}; not saved", error.what()));
            if (!is_stopped) return;
            restore(milestone_.open(), learner_.state().rate_factor);
            save();
        }
    }

    /// To the last milestone, at half the rate.
    void go_back(const DivergenceError& error, const TrainingOptions& options) {
        constexpr int kMostTimes = 10;
        const double factor = learner_.state().rate_factor / 2;
        if (factor < std::ldexp(1.0, -kMostTimes)) {
            throw NumericalError(
                fmt::format("{}; half the learning rate did not help {} times; the last "
                            "checkpoint is kept",
                            error.what(), kMostTimes));
        }
        restore(milestone_.open(), factor);
        const TrainingState& state = learner_.state();
        const std::string what = fmt::format(
            "{}; went back to epoch {}, the learning rate is {:g} times what it was meant to be "
            "from now on",
            error.what(), state.epoch, factor);
        log_.append(what);
        log_.sync();
        if (options.on_setback) options.on_setback(state, what);
    }

    void restore(const ModelFile& good, double rate_factor) {
        TrainingState state = good.state();
        state.rate_factor = rate_factor;
        good.load(*setup_.model);
        learner_.resume(state);
        open_metrics();
    }

    /// With the rows up to the epoch that is reached.
    void open_metrics() {
        metrics_.reset();
        metrics_.emplace(metrics_path(run_), learner_.term_names(), learner_.state().epoch);
    }

    bool is_long_unsaved() const {
        constexpr std::chrono::seconds kLongestUnsaved{120};
        return std::chrono::steady_clock::now() - saved_at_ > kLongestUnsaved;
    }

    const std::string& run_;
    TrainingSetup& setup_;
    Learner& learner_;
    LineFile& log_;
    Milestone milestone_;
    std::optional<MetricsFile> metrics_;
    std::chrono::steady_clock::time_point saved_at_ = std::chrono::steady_clock::now();
};

/// What belongs together, at once: an earlier run stands whole until this one does.
void write_beginning(const std::string& run, TrainingSetup& setup, Learner& learner) {
    const CodeTable codes = codes_to_save(setup, learner);
    OutputFiles files({checkpoint_path(run), metrics_path(run), config_path(run)});
    write_model(files.path(checkpoint_path(run)), *setup.model, setup.context, learner.state(),
                codes);
    write_file(files.path(metrics_path(run)),
               kept_metrics(metrics_path(run), learner.term_names(), learner.state().epoch));
    write_file(files.path(config_path(run)), write_config(setup.config, true));
    files.commit();
}

/// Begins with the run that the configuration names; nothing is written yet. Returns what the log
/// is to say of it.
std::string begin_with_run(TrainingSetup& setup, Learner& learner) {
    const StartingRun start =
        starting_run(setup.config.train.start_run, setup.model->rows(), setup.context);
    learner.start_from(start.components);
    setup.context.start_hash = start.hash;
    return start.note;
}

void go_on_from(const ModelFile& earlier, TrainingSetup& setup, Learner& learner, LineFile& log) {
    earlier.load(*setup.model);
    learner.resume(earlier.state());
    setup.context.start_hash = earlier.context().start_hash;
    log.append(fmt::format("resumed at epoch {}", learner.state().epoch));
}

std::string begin_line(const std::string& title) {
    return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC  {}", fmt::gmtime(std::time(nullptr)), title);
}

}  // namespace

bool has_checkpoint(const std::string& run) { return path_exists(checkpoint_path(run)); }

void require_free_run(const std::string& run, bool resume, bool force) {
    recover_folder(run);
    if (has_checkpoint(run) ? resume : path_exists(lock_path(run))) return;
    const bool is_foreign = path_exists(config_path(run)) || path_exists(metrics_path(run));
    if (!resume || is_foreign) require_free_folder(run, force);
}

TrainingResult train_run(const Config& config, const std::string& run,
                         const TrainingOptions& options) {
    RunLock lock(run, lock_path(run));
    recover_folder(run);
    std::optional<ModelFile> earlier;
    if (options.resume && has_checkpoint(run)) earlier.emplace(earlier_part(run, config));
    TrainingSetup setup(config);
    if (earlier) require_same_features(*earlier, setup, run);
    const std::unique_ptr<Learner> learner =
        setup.model->learner(setup.shapes, setup.context.train_shapes);
    const bool is_given = !earlier && !config.train.start_run.empty();
    const std::string given = is_given ? begin_with_run(setup, *learner) : "";

    lock.keep();
    LineFile log(log_path(run));
    log.append(begin_line(options.title));
    describe(setup, run, log);
    const auto warn = [&](const std::vector<std::string>& warnings) {
        for (const std::string& warning : warnings) {
            log.append("warning: " + warning);
            if (options.on_warning) options.on_warning(warning);
        }
    };
    warn(setup.warnings);
    if (earlier) {
        go_on_from(*earlier, setup, *learner, log);
    } else if (is_given) {
        log.append(given);
    } else {
        learner->start();
    }
    if (!earlier) {
        for (const std::string& note : learner->notes()) log.append(note);
        warn(learner->warnings());
    }
    const bool is_new = !earlier || earlier->context().config != setup.context.config;
    if (is_new) write_beginning(run, setup, *learner);
    Training training(run, setup, *learner, log);
    if (is_new) training.note_saved();
    const bool is_stopped = training.go_on(options);
    if (!is_stopped && learner->state().is_plateau) {
        log.append(
            fmt::format("plateau: the last {} epochs lowered the error by less than {} of it",
                        config.train.plateau_epochs, config.train.plateau_gain));
    }
    return {learner->state(), is_stopped};
}

TrainingProgress training_progress(const std::string& run, const TrainingDemand& demand) {
    if (!has_checkpoint(run)) return TrainingProgress::none;
    const std::string path = checkpoint_path(run);
    const ModelFile file(path);
    const ModelContext& context = file.context();
    if (context.source_hash != demand.source_hash || context.train_shapes != demand.train_shapes) {
        return TrainingProgress::none;
    }
    if (!is_start(demand.config.train.start_run, context.start_hash)) return TrainingProgress::none;
    ConfigChange change;
    try {
        change = config_change(parse_config(context.config, path), demand.config);
    } catch (const ConfigError&) {
        return TrainingProgress::none;  // of a version that had other keys
    }
    const int epochs = demand.config.train.epochs;
    if (!change.same_result() || file.state().epoch > epochs) return TrainingProgress::none;
    const bool is_over = file.state().is_plateau || file.state().epoch == epochs;
    return is_over && !change.filter && !change.saving && !change.length
               ? TrainingProgress::finished
               : TrainingProgress::begun;
}

}  // namespace mscomp
