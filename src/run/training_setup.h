// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/feature_scaler.h"
#include "mscomp/acap/surface_shapes.h"
#include "mscomp/base/distance_rows.h"
#include "mscomp/model/config.h"
#include "mscomp/model/model_file.h"

namespace mscomp {

/// Everything a training works on, in the order it is made. Stays where it was made: the model
/// borrows the context.
struct TrainingSetup {
    /// Opens the features and resolves the split; nothing is written. Throws what reading throws,
    /// UsageError where there is nothing to train on.
    explicit TrainingSetup(const Config& config);
    TrainingSetup(const TrainingSetup&) = delete;
    TrainingSetup& operator=(const TrainingSetup&) = delete;

    Config config;
    FeatureFile features;
    ModelContext context;
    SurfaceShapes shapes;  // of the features
    FeatureScaler scaler;
    std::vector<std::string> warnings;  // what is odd about whole shapes, one sentence each
    std::unique_ptr<DistanceRows> distances;
    std::unique_ptr<LearnedModel> model;
};

}  // namespace mscomp
