// SPDX-License-Identifier: MIT
#include "training_command.h"

#include <fmt/format.h>

#include <optional>

#include "cli/progress.h"
#include "cli/say.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/config/config_file.h"
#include "mscomp/run/peak_memory.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/training_run.h"
#include "training_progress.h"

namespace mscomp {
namespace {

TrainingResult train(const Config& config, const TrainingCommand& command) {
    std::optional<Progress> progress;
    TrainingOptions training;
    training.resume = command.resume;
    training.title = command.title;
    training.on_warning = [&](const std::string& sentence) {
        if (!command.common.quiet) say("mscomp: warning: {}\n", sentence);
    };
    training.on_begin = [&](const TrainingState& state) {
        progress.emplace("train", config.train.epochs,
                         progress_options(command.common.quiet, state.epoch));
    };
    training.on_epoch = [&](const EpochReport& report, const std::vector<std::string>& terms) {
        progress->update(report.state.epoch, describe_loss(report, terms));
    };
    training.on_setback = [&](const TrainingState& state, const std::string& what) {
        progress.reset();
        if (!command.common.quiet) say("mscomp: warning: {}\n", what);
        training.on_begin(state);
    };
    training.should_stop = interrupted;
    training.should_save = take_save_request;
    return train_run(config, command.run, training);
}

}  // namespace

Config configuration_of_run(const std::string& run, bool resume, const std::string& input,
                            const std::function<Config()>& made,
                            const std::vector<std::string>& overrides) {
    if (resume) recover_folder(run);
    Config config = resume && has_checkpoint(run)
                        ? read_config(config_path(run), overrides)
                        : parse_config(write_config(made(), false), input, overrides);
    anchor_paths(config, "");
    return config;
}

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

void run_training(const Config& config, const TrainingCommand& command,
                  std::vector<std::string> inputs) {
    const std::string& run = command.run;
    require_extension(run, "a run folder", {});
    require_free_run(run, command.resume, command.common.force);
    inputs.insert(inputs.end(), {config.data.features, config.data.split.path});
    if (!config.train.start_run.empty()) inputs.push_back(model_path(config.train.start_run));
    require_apart({config_path(run), checkpoint_path(run), metrics_path(run), log_path(run)},
                  inputs);
    const TrainingResult result = train(config, command);
    if (result.is_stopped) {
        throw_if_interrupted(fmt::format("interrupted after epoch {}, saved; go on with: {}",
                                         result.state.epoch, command.go_on));
    }
    print_out("{}: {} epochs, {} steps, loss {:.6g}; peak memory {:.0f} MiB\n", run,
              result.state.epoch, result.state.step, result.state.total, peak_memory_mib());
}

}  // namespace mscomp
