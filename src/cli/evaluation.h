// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>

#include "mscomp_commands.h"

namespace mscomp {

/// What `mscomp evaluate --json` prints (docs/evaluate.md): how well a run gives shapes back and
/// what its components are like, all numbers of docs/measures.md. With `options.output` also writes
/// table.csv and errors.png there. Prints nothing but progress, which `options.common.quiet` turns
/// off. Throws what reading the run and the features throws, UsageError for options that do not fit
/// them, Interrupted.
nlohmann::ordered_json evaluation_report(const EvaluateOptions& options);

}  // namespace mscomp
