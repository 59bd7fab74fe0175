// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// Files of a run folder.
std::string checkpoint_path(const std::string& run);
/// The checkpoint that a run goes back to when it diverged, where that is not the last one.
std::string milestone_path(const std::string& run);
std::string metrics_path(const std::string& run);
std::string config_path(const std::string& run);
std::string log_path(const std::string& run);
/// Held by the process that writes to the folder.
std::string lock_path(const std::string& run);
/// The checkpoint of a run folder, or the model file itself.
std::string model_path(const std::string& run_or_file);
/// What an evaluation of the run came to, kept by a sweep.
std::string evaluation_path(const std::string& run);

}  // namespace mscomp
