// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/model/learned_model.h"

namespace mscomp {

/// "loss 12.3  level0_reconstruction 4.5 ..." for the progress line.
std::string describe_loss(const EpochReport& report, const std::vector<std::string>& terms);

}  // namespace mscomp
