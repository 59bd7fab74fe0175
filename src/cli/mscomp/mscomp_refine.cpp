// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "mscomp/base/paths.h"
#include "mscomp/run/refinement.h"
#include "mscomp_commands.h"
#include "training_command.h"

namespace mscomp {
namespace {

Config effective_refinement(const RefineOptions& options) {
    Config config = configuration_of_run(
        options.output, options.resume, options.run, [&] { return refined_config(options.run); },
        options.overrides);
    config.train.start_run = absolute_path(options.run);
    return config;
}

std::string how_to_go_on(const RefineOptions& options) {
    std::string command =
        fmt::format("mscomp refine {} -o {}", quoted(options.run), quoted(options.output));
    for (const std::string& set : options.overrides) command += " --set " + quoted(set);
    return command + " --resume";
}

}  // namespace

void setup_refine(CLI::App& app) {
    const auto options = std::make_shared<RefineOptions>();
    CLI::App* command = app.add_subcommand(
        "refine", "Lower the error in space of the components of a run, as another run");
    command->add_option("RUN", options->run, "Run folder or model file, of features")->required();
    command->add_option("-o,--output", options->output, "Run folder to write")->required();
    command
        ->add_option("--set", options->overrides,
                     "key=value of a configuration of the kind multiscale, e.g. train.epochs=8; "
                     "repeatable")
        ->allow_extra_args(false);
    command->add_flag(
        "--resume", options->resume,
        "Go on from the last checkpoint of the run folder, as train does; RUN is read "
        "where there is none");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp refine swing.run -o finer.run --set train.epochs=8");
    command->callback([options] { run_refine(*options); });
}

void run_refine(const RefineOptions& options) {
    run_training(effective_refinement(options),
                 {options.output, "mscomp refine " + options.run, how_to_go_on(options),
                  options.resume, options.common},
                 {});
}

}  // namespace mscomp
