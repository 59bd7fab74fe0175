// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "mscomp/config/config_file.h"
#include "mscomp/run/unit_search.h"
#include "mscomp_commands.h"
#include "training_command.h"

namespace mscomp {
namespace {

Config effective_config(const UnitsOptions& options) {
    std::vector<std::string> overrides = options.overrides;
    if (options.components > 0) {
        overrides.push_back(fmt::format("model.components={}", options.components));
    }
    if (options.positions) overrides.emplace_back("model.rows=positions");
    // Of the input, whether there is a run to go on with or not: of another one it is refused.
    Config config =
        parse_config(write_config(unit_config(options.input), false), options.input, overrides);
    anchor_paths(config, "");
    return config;
}

}  // namespace

void setup_units(CLI::App& app) {
    const auto options = std::make_shared<UnitsOptions>();
    CLI::App* command = app.add_subcommand(
        "units", "Find components that are one thing each, as many as there are, as a run");
    command
        ->add_option("INPUT", options->input,
                     "Feature file; or run folder or model file, whose components are turned into "
                     "units")
        ->required();
    command->add_option("-o,--output", options->output, "Run folder to write")->required();
    command
        ->add_option("--components", options->components,
                     "At most so many, those that move most; as many as are found unless given")
        ->check(CLI::Range(1, 10'000));
    command->add_flag("--positions", options->positions,
                      "Find them in the aligned positions instead of the features; of a run, its "
                      "components decide");
    command
        ->add_option("--set", options->overrides,
                     "key=value of a configuration of the kind units, e.g. data.split.train=every; "
                     "repeatable")
        ->allow_extra_args(false);
    command->add_flag("--resume", options->resume,
                      "Leave a search that has ended alone, begin one anew that was stopped");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp units faces.safetensors -o faces-units.run");
    command->callback([options] { run_units(*options); });
}

void run_units(const UnitsOptions& options) {
    run_training(
        effective_config(options),
        {options.output, "mscomp units " + options.input, "", options.resume, options.common}, {});
}

}  // namespace mscomp
