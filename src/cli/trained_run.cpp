// SPDX-License-Identifier: MIT
#include "trained_run.h"

#include <filesystem>
#include <utility>

#include "mscomp/acap/extract.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/config_file.h"

namespace mscomp {
namespace {

std::string in_folder(const std::string& folder, const char* name) {
    return (std::filesystem::path(folder) / name).string();
}

}  // namespace

std::string checkpoint_path(const std::string& run) {
    return in_folder(run, "checkpoint.safetensors");
}
std::string metrics_path(const std::string& run) { return in_folder(run, "metrics.csv"); }
std::string config_path(const std::string& run) { return in_folder(run, "config.yaml"); }
std::string log_path(const std::string& run) { return in_folder(run, "log.txt"); }

FeatureScaler TrainedRun::scaler() const {
    FeatureScaler scaler;
    scaler.offset = context().offset;
    scaler.factor = context().factor;
    return scaler;
}

std::vector<nn::Component> TrainedRun::components() {
    std::vector<float> reference;
    for (int v = 0; v < context().reference.vertex_count(); ++v) {
        reference.insert(reference.end(), kReferenceFeature.begin(), kReferenceFeature.end());
    }
    scaler().scale(reference);
    return nn::extract_components(*model, file.codes(), reference, context().factor, config.filter,
                                  *distances);
}

TrainedRun open_run(const std::string& path, int batch) {
    const std::string file = std::filesystem::is_directory(path) ? checkpoint_path(path) : path;
    TrainedRun run{nn::ModelFile(file), {}, nullptr, nullptr};
    try {
        run.config = parse_config(run.context().config, file + " (configuration)");
        parse_edge_weights(run.context().weights);
    } catch (const Error& error) {
        throw CheckpointError(file, error.what());
    }
    const TriangleMesh& reference = run.context().reference;
    run.distances = make_distances(
        reference, {run.context().largest_distance, run.context().largest_distance_exact});
    run.model = make_model(run.config, reference, *run.distances, nn::ModelUse::reading, batch);
    run.file.load(*run.model);
    return run;
}

std::unique_ptr<nn::Model<float>> make_model(const nn::Config& config,
                                             const TriangleMesh& reference, DistanceRows& distances,
                                             nn::ModelUse use, int batch) {
    std::vector<double> weights;
    if (nn::wants_edge_weights(config)) weights = ring_weights(reference, EdgeWeights::cotangent);
    return nn::make_model(config, one_rings_of_faces(reference.vertex_count(), reference.faces),
                          weights, distances, use, batch);
}

std::unique_ptr<NormalizedGeodesics> make_distances(const TriangleMesh& reference,
                                                    const GeodesicNormalizer& normalizer) {
    return std::make_unique<NormalizedGeodesics>(HeatGeodesics(reference),
                                                 normalizer.largest_distance);
}

}  // namespace mscomp
