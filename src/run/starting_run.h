// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "mscomp/model/given_components.h"
#include "mscomp/run/trained_run.h"

namespace mscomp {

/// What a training begins with that begins with another run.
struct StartingRun {
    GivenComponents components;
    std::string hash;  // of its model file
    std::string note;  // a sentence about it, for the log
};

/// The run `path` as the beginning of a training of components of `rows` in `context`. Throws
/// UsageError for components of other rows, another reference, other features or edge weights, or a
/// run that has learnt from shapes that do not train here: they would be unseen no more. Else as
/// open_run.
StartingRun starting_run(const std::string& path, ShapeRows rows, const ModelContext& context);

/// Whether the run `path` is, as far as it still is there, what a training began with.
bool is_start(const std::string& path, const std::string& hash);

/// Throws UsageError for a run whose components change other rows.
void require_rows(const TrainedRun& run, ShapeRows rows);

}  // namespace mscomp
