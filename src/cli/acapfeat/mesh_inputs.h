// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace mscomp {

/// Mesh files named on the command line: `inputs` (files, folders, globs, in natural order) or the
/// lines of the file `list` (in its order, relative to its folder; not those that begin with #).
/// Throws UsageError unless exactly one of the two is given or if an input matches nothing, IoError
/// for a missing file.
std::vector<std::string> mesh_paths(const std::vector<std::string>& inputs,
                                    const std::string& list);

}  // namespace mscomp
