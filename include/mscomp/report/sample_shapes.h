// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "mscomp/model/synthesis.h"
#include "mscomp/run/trained_run.h"

namespace mscomp {

struct SampleShapesOptions {
    CodeDistribution distribution = CodeDistribution::fitted;
    int count = 12;
    std::uint64_t seed = 0;
    std::string format = "obj";  // obj | ply | off
    int tile = 300;              // pixels of one shape in overview.png
    std::string title;           // of overview.png
    std::function<void(std::int64_t done, std::int64_t total)> on_progress;  // may be empty
};

/// Writes random shapes of a run into `folder`, which is made if it is missing (docs/synthesis.md):
/// sample_0.obj, ... (sample_00.obj for more than nine), codes.csv, and overview.png of the
/// first 60. Returns the paths of the meshes. Throws IoError, Interrupted, and UsageError as
/// CodeSampler.
std::vector<std::string> sample_shapes(TrainedRun& run, const std::string& folder,
                                       const SampleShapesOptions& options);

}  // namespace mscomp
