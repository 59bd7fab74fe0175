// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "mscomp/config/config_file.h"
#include "mscomp_commands.h"
#include "training_command.h"

namespace mscomp {
namespace {

std::string run_folder(const TrainOptions& options) {
    if (!options.output.empty()) return options.output;
    return std::filesystem::path(options.config).replace_extension(".run").string();
}

/// The run folder lies elsewhere: what was relative to the config has to be found from there.
Config effective_config(const TrainOptions& options) {
    Config config = read_config(options.config, options.overrides);
    anchor_paths(config, std::filesystem::path(options.config).parent_path().string());
    return config;
}

std::string how_to_go_on(const TrainOptions& options, const std::string& run) {
    std::string command = fmt::format("mscomp train {} -o {}", quoted(options.config), quoted(run));
    for (const std::string& set : options.overrides) command += " --set " + quoted(set);
    return command + " --resume";
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
    // A run may go on with its own configuration, which is then written as it was read.
    std::vector<std::string> inputs;
    if (!options.resume) inputs.push_back(options.config);
    run_training(effective_config(options),
                 {run, "mscomp train " + options.config, how_to_go_on(options, run), options.resume,
                  options.common},
                 std::move(inputs));
}

}  // namespace mscomp
