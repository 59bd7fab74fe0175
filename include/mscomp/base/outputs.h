// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// Throws UsageError naming --force if `path` exists and `force` is off, or if it is a folder. What
/// a killed process left half done beside it is undone first.
void require_free_file(const std::string& path, bool force);

/// Throws UsageError naming --force if the folder `path` has something in it and `force` is off,
/// or if `path` is a file. With `force`, files of the same names are replaced, others stay.
void require_free_folder(const std::string& path, bool force);

/// Creates `folder` and its parents where missing. Throws IoError with the system's reason, of
/// `output` if the folder is made for that.
void create_folder(const std::string& folder, const std::string& output = {});

}  // namespace mscomp
