// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>

#include "cli/progress.h"
#include "cli/say.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/path_from.h"
#include "mscomp/base/paths.h"
#include "mscomp/config/config_file.h"
#include "mscomp/run/peak_memory.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/training_run.h"
#include "mscomp_commands.h"
#include "training_progress.h"

namespace mscomp {
namespace {

std::string run_folder(const TrainOptions& options) {
    if (!options.output.empty()) return options.output;
    return std::filesystem::path(options.config).replace_extension(".run").string();
}

Config effective_config(const TrainOptions& options) {
    Config config = read_config(options.config, options.overrides);
    const std::string folder = std::filesystem::path(options.config).parent_path().string();
    // The run folder lies elsewhere: what was relative to the config has to be found from there.
    const auto anchored = [&](const std::string& path) {
        return absolute_path(path_from(folder, path));
    };
    config.data.features = anchored(config.data.features);
    if (!config.data.split.path.empty()) config.data.split.path = anchored(config.data.split.path);
    return config;
}

/// A run may go on with its own configuration, which is then written as it was read.
void require_own_outputs(const TrainOptions& options, const Config& config,
                         const std::string& run) {
    std::vector<std::string> inputs{config.data.features, config.data.split.path};
    if (!options.resume) inputs.push_back(options.config);
    require_apart({config_path(run), checkpoint_path(run), metrics_path(run), log_path(run)},
                  inputs);
}

/// As a shell reads it back.
std::string quoted(const std::string& text) {
    const bool is_plain =
        !text.empty() &&
        text.find_first_not_of(
            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%") ==
            std::string::npos;
    if (is_plain) return text;
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

std::string how_to_go_on(const TrainOptions& options, const std::string& run, std::int64_t epochs) {
    std::string command = fmt::format("mscomp train {} -o {}", quoted(options.config), quoted(run));
    for (const std::string& set : options.overrides) command += " --set " + quoted(set);
    return fmt::format("interrupted after epoch {}, saved; go on with: {} --resume", epochs,
                       command);
}

TrainingResult train(const TrainOptions& options, const Config& config, const std::string& run) {
    std::optional<Progress> progress;
    TrainingOptions training;
    training.resume = options.resume;
    training.title = "mscomp train " + options.config;
    training.on_warning = [&](const std::string& sentence) {
        if (!options.common.quiet) say("mscomp: warning: {}\n", sentence);
    };
    training.on_begin = [&](const TrainingState& state) {
        progress.emplace("train", config.train.epochs,
                         progress_options(options.common.quiet, state.epoch));
    };
    training.on_epoch = [&](const EpochReport& report, const std::vector<std::string>& terms) {
        progress->update(report.state.epoch, describe_loss(report, terms));
    };
    training.on_setback = [&](const TrainingState& state, const std::string& what) {
        progress.reset();
        if (!options.common.quiet) say("mscomp: warning: {}\n", what);
        training.on_begin(state);
    };
    training.should_stop = interrupted;
    training.should_save = take_save_request;
    return train_run(config, run, training);
}

}  // namespace

void setup_train(CLI::App& app) {
    const auto options = std::make_shared<TrainOptions>();
    CLI::App* command = app.add_subcommand("train", "Learn components from a feature file");
    command->add_option("CONFIG", options->config, "YAML configuration (see mscomp init)")
        ->required();
    command->add_option("-o,--output", options->output,
                        "Run folder to write [name of CONFIG with .run]");
    command
        ->add_option("--set", options->overrides,
                     "key=value that replaces what CONFIG says, e.g. train.epochs=500; repeatable")
        ->allow_extra_args(false);
    command->add_flag("--resume", options->resume,
                      "Go on from the last checkpoint of the run folder, if there is one. The "
                      "signals INT, TERM, HUP, USR2 and XCPU save one and stop, USR1 saves one and "
                      "goes on");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp train config.yaml -o swing.run --set train.epochs=500");
    command->callback([options] { run_train(*options); });
}

void run_train(const TrainOptions& options) {
    const std::string run = run_folder(options);
    const Config config = effective_config(options);
    require_extension(run, "a run folder", {});
    require_free_run(run, options.resume, options.common.force);
    require_own_outputs(options, config, run);
    const TrainingResult result = train(options, config, run);
    if (result.is_stopped) throw_if_interrupted(how_to_go_on(options, run, result.state.epoch));
    print_out("{}: {} epochs, {} steps, loss {:.6g}; peak memory {:.0f} MiB\n", run,
              result.state.epoch, result.state.step, result.state.total, peak_memory_mib());
}

}  // namespace mscomp
