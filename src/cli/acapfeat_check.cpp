// SPDX-License-Identifier: MIT
#include "acapfeat_commands.h"

namespace mscomp {

void setup_check(CLI::App&) {}

void run_check(const CheckCommand&) {}

}  // namespace mscomp
