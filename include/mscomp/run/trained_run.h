// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/model/components.h"
#include "mscomp/model/config.h"
#include "mscomp/model/learned_model.h"
#include "mscomp/model/model_file.h"

namespace mscomp {

/// A trained model ready to encode and decode, from a run folder or a model file alone.
struct TrainedRun {
    ModelFile file;
    Config config;
    std::unique_ptr<DistanceRows> distances;
    std::unique_ptr<LearnedModel> model;

    const ModelContext& context() const { return file.context(); }
    const TriangleMesh& reference() const { return context().reference; }
    /// All components, coarse to fine, judged by the filter of the configuration.
    std::vector<Component> components() {
        return extract_components(*model, file.codes(), config.filter, *distances, context().scale,
                                  context().squared_error);
    }
};

/// `batch`: how many shapes are worth encoding together. Throws IoError (nothing there) or
/// CheckpointError (unusable).
TrainedRun open_run(const std::string& path, int batch = 1);

}  // namespace mscomp
