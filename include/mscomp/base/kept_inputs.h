// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

// Outputs that would take the place of inputs, or of files of another kind.

namespace mscomp {

/// Throws UsageError if one of the files `outputs` is one of the files `inputs`, by whatever name
/// or link. Paths that lead nowhere are nobody's input.
void require_apart(const std::vector<std::string>& outputs, const std::vector<std::string>& inputs);

/// The files that stand in a folder with one of these extensions ("obj"); none if there is no
/// folder. What is written into it under names that are not known yet may replace them.
std::vector<std::string> files_of_kind(const std::string& folder,
                                       const std::vector<std::string>& extensions);

/// Throws UsageError if the name of an output, which is `what` ("a feature file"), ends as files of
/// another kind do. `extensions` are those of its own kind, the first being the usual one; with
/// none it is a folder's name, which may be of any kind where the folder is there already.
void require_extension(const std::string& output, const std::string& what,
                       const std::vector<std::string>& extensions);

}  // namespace mscomp
