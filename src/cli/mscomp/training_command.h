// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/program.h"
#include "mscomp/model/config.h"

namespace mscomp {

/// A training as a command asks for it.
struct TrainingCommand {
    std::string run;    // folder
    std::string title;  // what began this, for the log
    std::string go_on;  // command line that goes on where this one is interrupted
    bool resume = false;
    CommonOptions common;
};

/// For a command that makes its configuration from `input`: what `made` returns, or that of the run
/// folder where this goes on from a checkpoint, which needs what it began with no more; `overrides`
/// (key=value) laid over it.
Config configuration_of_run(const std::string& run, bool resume, const std::string& input,
                            const std::function<Config()>& made,
                            const std::vector<std::string>& overrides);

/// As a shell reads it back.
std::string quoted(const std::string& text);

/// Trains, shows how far that is and prints what came of it. `inputs`, and the files that the
/// configuration names, are none that are written. Throws what train_run throws, UsageError where
/// the folder is not free, and what an interruption is.
void run_training(const Config& config, const TrainingCommand& command,
                  std::vector<std::string> inputs);

}  // namespace mscomp
