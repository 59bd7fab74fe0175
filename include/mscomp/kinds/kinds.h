// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/model/kind.h"

namespace mscomp {

/// All methods that can be trained; the first is the one taken by default.
const std::vector<Kind>& all_kinds();
std::vector<std::string> kind_names();
/// Throws UsageError listing the kinds.
const Kind& kind_named(const std::string& name);

/// The recommended configuration of a kind, without features. Throws as kind_named.
Config default_config(const std::string& kind);

}  // namespace mscomp
