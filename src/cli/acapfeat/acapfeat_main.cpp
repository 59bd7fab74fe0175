// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>

#include "acapfeat_commands.h"
#include "cli/program.h"

int main(int argc, char** argv) {
    mscomp::wait_asleep(argv);
    CLI::App app("Turns meshes of one connectivity into ACAP features and back", "acapfeat");
    mscomp::setup_program(app);
    mscomp::setup_check(app);
    mscomp::setup_extract(app);
    mscomp::setup_reconstruct(app);
    mscomp::setup_info(app);
    mscomp::setup_convert(app);
    mscomp::setup_generate(app);
    return mscomp::run_program(app, argc, argv);
}
