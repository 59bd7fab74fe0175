// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "acapfeat_commands.h"
#include "mscomp/acap/generate.h"
#include "mscomp/cli/outputs.h"

namespace mscomp {

void setup_generate(CLI::App& app) {
    const auto options = std::make_shared<GenerateCommand>();
    CLI::App* command =
        app.add_subcommand("generate", "A built-in sequence whose true components are known");
    command->add_option("NAME", options->name, "Which sequence: arm")
        ->required()
        ->check(CLI::IsMember({"arm"}));
    command->add_option("-o,--output", options->output, "Folder to write it to")->required();
    command
        ->add_option("--frames", options->frames, "Number of shapes, the undeformed one included")
        ->capture_default_str();
    command->add_option("--seed", options->seed, "Which motion")->capture_default_str();
    command->add_option("--vertices", options->vertices, "Vertices at least")
        ->capture_default_str();
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat generate arm -o arm --frames 60 --seed 0");
    command->callback([options] { run_generate(*options); });
}

void run_generate(const GenerateCommand& options) {
    require_free_folder(options.output, options.common.force);
    write_generated(generate_arm(options.frames, options.seed, options.vertices), options.output);
    fmt::print("{}: {} shapes of {} and what they are made of\n", options.output, options.frames,
               options.name);
}

}  // namespace mscomp
