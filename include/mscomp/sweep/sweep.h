// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mscomp/model/learned_model.h"

namespace mscomp {

struct SweepOptions {
    std::string sweep;                   // YAML file (docs/sweep.md)
    std::string output;                  // folder of runs and results
    std::vector<std::string> overrides;  // key=value for all points
    bool force = false;                  // the folder may hold something else
    /// What happens, for who waits; all may be empty.
    std::function<void(std::size_t index, std::size_t count, const std::string& name)> on_point;
    std::function<void(const TrainingState& state, int epochs)> on_training;
    std::function<void(const EpochReport& report, const std::vector<std::string>& terms)> on_epoch;
    std::function<void(const TrainingState& state, int epochs, const std::string& what)> on_setback;
    std::function<void(std::int64_t done, std::int64_t total)> on_measure;
};

/// What a sweep came to.
struct SweepResult {
    std::string table;                // in Markdown
    std::vector<std::string> failed;  // points that failed, each with why
    std::size_t points = 0;
};

/// Trains and measures every point of a sweep that is not done already, and keeps table.csv,
/// table.md and plot.svg up to date after each. A number that is not finite is the result of a
/// point, not the end of all. `report` becomes what `mscomp sweep --json` prints. Throws what
/// reading, training and measuring throw, UsageError naming --force if the folder has something in
/// it that is not of a sweep, Interrupted.
SweepResult run_sweep(const SweepOptions& options, nlohmann::ordered_json& report);

}  // namespace mscomp
