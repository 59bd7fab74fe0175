// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mscomp/model/config.h"

namespace mscomp {

/// What `mscomp init KIND` prints: the commented defaults of that kind, with a feature file to be
/// replaced. Throws UsageError listing the known kinds.
std::string config_template(const std::string& kind);

/// Reads a YAML configuration over the defaults of its model.kind, then applies `overrides`
/// ("train.epochs=100", "model.levels[0].components=5", "model.levels=[{components: 8,
/// sparsity_range: 0.3}]"; the value is YAML, a mapping sets the keys it names and leaves the
/// others, a list replaces the list).
///
/// Strict: an unknown or repeated key, another type, a value out of range, something required that
/// is missing or broken YAML throw ConfigError with file, line, column, dotted key, got and wanted,
/// and for an unknown key the nearest known one. Throws IoError if the file cannot be read.
Config read_config(const std::string& path, const std::vector<std::string>& overrides);

/// The same from text in memory; `path` is only used in messages.
Config parse_config(std::string_view yaml, const std::string& path,
                    const std::vector<std::string>& overrides = {});

/// Makes the file names of a configuration absolute; relative ones count from `folder`.
void anchor_paths(Config& config, const std::string& folder);

/// The whole configuration as YAML, every key in the order of the documentation; with comments,
/// each key says what it does and what it may be. parse_config gives back `config` exactly.
std::string write_config(const Config& config, bool with_comments);

}  // namespace mscomp
