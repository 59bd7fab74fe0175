// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "mscomp/model/config.h"

namespace mscomp {

/// The configuration of a training that finds units (kind units) in `input`: a feature file, all of
/// whose shapes it learns from, or a run of any kind (folder or model file), whose components then
/// say what its training shapes are, and whether units change features or positions. File names are
/// absolute. Throws as open_run and the readers do.
Config unit_config(const std::string& input);

}  // namespace mscomp
