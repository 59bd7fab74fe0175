// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/progress.h"
#include "cli/say.h"
#include "mscomp/base/error.h"
#include "mscomp/base/json_text.h"
#include "mscomp/sweep/sweep.h"
#include "mscomp_commands.h"
#include "training_progress.h"

namespace mscomp {
namespace {

void require_no_failure(const SweepResult& result) {
    if (result.failed.empty()) return;
    throw NumericalError(fmt::format("{} of {} points failed, the others are done: {}",
                                     result.failed.size(), result.points,
                                     fmt::join(result.failed, ", ")));
}

/// What a sweep shows while it runs: the point, then how far its training and measuring are.
class SweepProgress {
  public:
    explicit SweepProgress(bool quiet) : quiet_(quiet) {}

    void attach(SweepOptions& options) {
        options.on_point = [this](std::size_t index, std::size_t count, const std::string& name) {
            training_.reset();
            measuring_.reset();
            if (quiet_) return;
            say("sweep: point {} of {}: {}\n", index + 1, count, name);
        };
        options.on_training = [this](const TrainingState& state, int epochs) {
            training_.emplace("train", epochs, progress_options(quiet_, state.epoch));
        };
        options.on_epoch = [this](const EpochReport& report,
                                  const std::vector<std::string>& terms) {
            training_->update(report.state.epoch, describe_loss(report, terms));
        };
        options.on_setback = [this](const TrainingState& state, int epochs,
                                    const std::string& what) {
            training_.reset();
            if (!quiet_) say("mscomp: warning: {}\n", what);
            training_.emplace("train", epochs, progress_options(quiet_, state.epoch));
        };
        options.on_measure = [this](std::int64_t done, std::int64_t total) {
            training_.reset();
            if (!measuring_) measuring_.emplace("evaluate", total, progress_options(quiet_));
            measuring_->update(done);
        };
    }

  private:
    bool quiet_;
    std::optional<Progress> training_, measuring_;
};

}  // namespace

void setup_sweep(CLI::App& app) {
    const auto options = std::make_shared<SweepCommand>();
    CLI::App* command =
        app.add_subcommand("sweep", "Train and measure many variants of a configuration");
    command->add_option("SWEEP", options->sweep, "YAML file of base, points, measure and plot")
        ->required();
    command
        ->add_option("-o,--output", options->output,
                     "Folder of runs and results; an earlier one of the sweep goes on")
        ->required();
    command
        ->add_option("--set", options->overrides,
                     "key=value for all points, e.g. data.features=F; repeatable")
        ->allow_extra_args(false);
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command,
                "mscomp sweep data/ablations/levels.yaml --set data.features=arm.safetensors "
                "--set 'data.split={train: every, step: 2}' -o levels");
    command->callback([options] { run_sweep_command(*options); });
}

void run_sweep_command(const SweepCommand& command) {
    SweepOptions options;
    options.sweep = command.sweep;
    options.output = command.output;
    options.overrides = command.overrides;
    options.force = command.common.force;
    SweepProgress progress(command.common.quiet);
    progress.attach(options);
    nlohmann::ordered_json report = nullptr;
    const SweepResult result = run_sweep(options, report);
    if (command.common.json) {
        print_lines(json_text(report, 2) + "\n");
    } else {
        print_lines(result.table);
    }
    require_no_failure(result);
}

}  // namespace mscomp
