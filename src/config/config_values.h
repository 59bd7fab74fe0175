// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <functional>
#include <string>

#include "mscomp/base/error.h"
#include "mscomp/model/keys.h"

namespace mscomp {

/// Line and column of `node` in `path`, counted from 1.
FilePosition position_of(const YAML::Node& node, const std::string& path);

/// Puts the value of `node` into the field of `key`, which holds neither a section nor levels.
/// False, with the field as it was, if the node is of another type or out of range.
bool read_value(const Key& key, const YAML::Node& node);

/// What a node is, as it would be said to its author: "a list", "nothing", "\"many\"".
std::string found(const YAML::Node& node);

}  // namespace mscomp
