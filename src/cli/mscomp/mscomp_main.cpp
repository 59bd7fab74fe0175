// SPDX-License-Identifier: MIT
#include "cli/program.h"
#include "mscomp_commands.h"

int main(int argc, char** argv) {
    using namespace mscomp;
    return run_main(
        {"mscomp",
         "Learns multiscale, localised deformation components from ACAP features",
         {setup_init, setup_train, setup_refine, setup_units, setup_run_info, setup_export,
          setup_decode, setup_evaluate, setup_sweep, setup_synthesize, setup_sample}},
        argc, argv);
}
