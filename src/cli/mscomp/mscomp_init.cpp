// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "cli/program.h"
#include "cli/say.h"
#include "mscomp/config/config_file.h"
#include "mscomp/kinds/kinds.h"
#include "mscomp_commands.h"

namespace mscomp {

void setup_init(CLI::App& app) {
    const auto options = std::make_shared<InitOptions>();
    options->kind = kind_names().front();
    CLI::App* command = app.add_subcommand("init", "Print the commented defaults of a model kind");
    command
        ->add_option("KIND", options->kind,
                     fmt::format("Model kind: {}", fmt::join(kind_names(), ", ")))
        ->type_name(fmt::format("TEXT:{{{}}}", fmt::join(kind_names(), ",")))
        ->capture_default_str();
    set_example(*command, "mscomp init > config.yaml");
    command->callback([options] { run_init(*options); });
}

void run_init(const InitOptions& options) { print_lines(config_template(options.kind)); }

}  // namespace mscomp
