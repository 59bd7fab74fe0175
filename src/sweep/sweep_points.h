// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "sweep_file.h"

namespace mscomp {

/// A value as it is written on one line: "0.3", "[{components: 8, sparsity_range: 0.3}]".
std::string value_text(const YAML::Node& value);

/// The entries of a mapping that may have the keys `known`, each once. Throws ConfigError with
/// place and the nearest known key.
std::vector<Setting> known_entries(const YAML::Node& node, const std::string& path,
                                   const std::string& dotted,
                                   const std::vector<std::string>& known);

/// The points that `points:` describes: `list` in its order, for each the product of `grid`, its
/// last key fastest. Throws ConfigError.
std::vector<SweepPoint> read_points(const YAML::Node& node, const std::string& path);

}  // namespace mscomp
