// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>

#include "cli/program.h"
#include "mscomp_commands.h"

int main(int argc, char** argv) {
    mscomp::wait_asleep(argv);
    CLI::App app("Learns multiscale, localised deformation components from ACAP features",
                 "mscomp");
    mscomp::setup_program(app);
    mscomp::setup_init(app);
    mscomp::setup_train(app);
    mscomp::setup_run_info(app);
    mscomp::setup_export(app);
    mscomp::setup_decode(app);
    mscomp::setup_evaluate(app);
    mscomp::setup_sweep(app);
    mscomp::setup_synthesize(app);
    mscomp::setup_sample(app);
    return mscomp::run_program(app, argc, argv);
}
