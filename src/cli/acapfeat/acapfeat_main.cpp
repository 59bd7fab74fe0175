// SPDX-License-Identifier: MIT
#include "acapfeat_commands.h"
#include "cli/program.h"

int main(int argc, char** argv) {
    using namespace mscomp;
    return run_main({"acapfeat",
                     "Turns meshes of one connectivity into ACAP features and back",
                     {setup_check, setup_extract, setup_reconstruct, setup_info, setup_convert,
                      setup_generate}},
                    argc, argv);
}
