// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace mscomp {

/// What of a run is measured, and on which shapes.
struct EvaluationOptions {
    std::string run;              // run folder or model file
    std::string features;         // empty: the file the run was trained on
    std::string split;            // all | train | test; empty: test where the run has such shapes
    std::vector<int> handles;     // how many, for E_rms against their number
    std::vector<int> components;  // likewise
    std::string fit = "both";     // a choice of fits.h
    bool kept = false;            // only what the filter keeps acts, with refitted codes
    std::string order = "auto";   // sequence | set | auto: by the run's split
    int worst = 3;                // how many of the worst shapes are named and drawn
    std::string units;            // CSV of true weights; empty: none
    std::string truth;            // truth.json of a generated set; empty: none
    std::string output;           // folder for tables and pictures; empty: none
    /// Shapes done of all; what a shape has to go through counts in parts. May be empty.
    std::function<void(std::int64_t done, std::int64_t total)> on_progress;
};

/// What `mscomp evaluate --json` prints (docs/evaluate.md): how well a run gives shapes back and
/// what its components are like, all numbers of docs/measures.md. With `options.output` also writes
/// table.csv, components.csv and, unless `worst` is 0, errors.png there. Throws what reading the
/// run and the features throws, UsageError for options that are none or do not fit them,
/// Interrupted.
nlohmann::ordered_json evaluation_report(const EvaluationOptions& options);

}  // namespace mscomp
