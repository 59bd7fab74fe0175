// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "mscomp/model/config.h"

namespace mscomp {

/// The configuration of a training that begins with the components of a run (folder or model file)
/// and lowers their error in space (method §9, stage B): kind multiscale with no rounds of least
/// squares, on the data of the run, with its filter and seed; its levels hold the supports that
/// components have. A run of kind multiscale keeps its own settings of the model. File names are
/// absolute. Throws UsageError for a run whose components are no features, and as open_run.
Config refined_config(const std::string& run);

}  // namespace mscomp
