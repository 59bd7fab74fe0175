// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// Throws ConfigError at `path` and `key` if `yaml` holds a second document, YAML::Exception if it
/// is no YAML up to there. A text that passes can be given to YAML::Load, which would otherwise
/// take the first document and be silent about the others.
void require_one_document(const std::string& yaml, const std::string& path, const std::string& key);

}  // namespace mscomp
