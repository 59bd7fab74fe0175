// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mscomp/acap/feature_scaler.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/geodesic/heat_geodesics.h"
#include "mscomp/nn/components.h"
#include "mscomp/nn/config.h"
#include "mscomp/nn/kinds.h"
#include "mscomp/nn/model_file.h"

namespace mscomp {

/// Files of a run folder.
std::string checkpoint_path(const std::string& run);
std::string metrics_path(const std::string& run);
std::string config_path(const std::string& run);
std::string log_path(const std::string& run);

/// A trained model ready to encode and decode, from a run folder or a model file alone.
struct TrainedRun {
    nn::ModelFile file;
    nn::Config config;
    std::unique_ptr<NormalizedGeodesics> distances;
    std::unique_ptr<nn::Model<float>> model;

    const nn::ModelContext& context() const { return file.context(); }
    FeatureScaler scaler() const;
    /// All components, coarse to fine, judged by the filter of the configuration.
    std::vector<nn::Component> components();
};

/// Throws IoError (nothing there) or CheckpointError (unusable).
TrainedRun open_run(const std::string& path, int batch);

/// An untrained model of the configured kind on `reference`.
std::unique_ptr<nn::Model<float>> make_model(const nn::Config& config,
                                             const TriangleMesh& reference, DistanceRows& distances,
                                             nn::ModelUse use, int batch);

/// Geodesics of a reference with the normaliser known or computed.
std::unique_ptr<NormalizedGeodesics> make_distances(const TriangleMesh& reference,
                                                    const GeodesicNormalizer& normalizer);

}  // namespace mscomp
