// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "mscomp/render/viewpoint.h"
#include "mscomp/run/trained_run.h"

namespace mscomp {

struct ComponentExportOptions {
    bool all = false;               // dropped and merged components too
    int tile = 240;                 // pixels of one picture in the overview
    std::optional<Point> up;        // otherwise guessed
    std::optional<Viewpoint> view;  // of all pictures; otherwise chosen for each
    std::function<void(std::int64_t done, std::int64_t total)> on_progress;  // may be empty
};

/// Writes the components of a run into `folder` (docs/components.md): both ends of each as coloured
/// meshes, overview.png, and components.json, which is returned; `run_name` stands in it. Meshes of
/// an earlier export that the folder has are removed. Throws IoError, Interrupted.
nlohmann::ordered_json export_components(TrainedRun& run, const std::string& run_name,
                                         const std::string& folder,
                                         const ComponentExportOptions& options = {});

}  // namespace mscomp
