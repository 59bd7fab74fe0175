// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "nn/model.h"

namespace mscomp::nn {

/// What a model file holds besides parameters, so that it needs nothing beside it.
struct ModelContext {
    std::string config;                 // effective configuration, YAML
    std::string source;                 // feature file the model was trained on
    std::string weights = "cotangent";  // edge weights of the features
    TriangleMesh reference;
    std::array<double, kFeatureDim> offset{};  // scaled = (feature - offset) * factor
    std::array<double, kFeatureDim> factor{};
    /// The same with the papers' two global ranges (center: minmax), for [A] eq. 8.
    std::array<double, kFeatureDim> minmax_offset{};
    std::array<double, kFeatureDim> minmax_factor{};
    std::string source_hash;      // XXH3 of the feature file, empty if it has none
    double largest_distance = 0;  // geodesic normaliser, unit of the mesh
    bool largest_distance_exact = false;
    std::vector<int> train_shapes, test_shapes;  // indices into the feature file
};

/// How far training has come.
struct TrainingState {
    std::int64_t epoch = 0;  // epochs done
    std::int64_t step = 0;   // updates done
    double total = 0;        // total loss of the last step
    /// Mean error of the last whole plateau window (0: none yet), the sum and the epochs since
    /// then.
    double window_mean = 0, window_sum = 0;
    std::int64_t window_epochs = 0;
    bool is_plateau = false;  // the last window gained too little: training is over
};

/// Writes model, context, optimiser state and the codes of the training shapes (per level, (n,
/// A*K)) as one atomic, checked step. Throws IoError.
void write_model(const std::string& path, Model<float>& model, const ModelContext& context,
                 const TrainingState& state, const std::vector<std::vector<float>>& codes);

/// A model file opened for reading; parameters are read into a model of the same configuration.
/// Every problem, truncation and altered bytes included, is a CheckpointError with the path.
class ModelFile {
  public:
    explicit ModelFile(const std::string& path);
    ModelFile(ModelFile&&) noexcept;
    ModelFile& operator=(ModelFile&&) noexcept;
    ~ModelFile();

    const ModelContext& context() const;
    const TrainingState& state() const;
    /// Codes of the training shapes per level, (n, A*K).
    const std::vector<std::vector<float>>& codes() const;
    /// Parameters, and Adam's moments too; throws CheckpointError where shapes differ.
    void load(Model<float>& model) const;

  private:
    void load_centers(Model<float>& model) const;
    void load_acting(Model<float>& model) const;

    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace mscomp::nn
