// SPDX-License-Identifier: MIT
#include "acapfeat_commands.h"

namespace mscomp {

void setup_convert(CLI::App&) {}

void run_convert(const ConvertCommand&) {}

}  // namespace mscomp
