// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/base/vertex_places.h"
#include "mscomp/model/learned_model.h"

namespace mscomp {

/// What a model file holds besides the model's own arrays, so that it needs nothing beside it.
struct ModelContext {
    std::string config;                 // effective configuration, YAML
    std::string source;                 // feature file the model was trained on
    std::string weights = "cotangent";  // edge weights of the features
    TriangleMesh reference;             // on the W places: the mesh that the model knows
    VertexPlaces places;                // of the vertices of the files,
    TriangleMesh reference_of_files{};  // and these; empty if every vertex is a place of its own
    MetricScale scale;                  // of the features, fitted on the training shapes
    MetricScale minmax;           // the papers' two global ranges (center: minmax), for [A] eq. 8
    std::string source_hash;      // XXH3 of the feature file, empty if it has none
    std::string start_hash;       // XXH3 of the model file it began with, empty if with none
    double largest_distance = 0;  // geodesic normaliser, unit of the mesh
    bool largest_distance_exact = false;
    std::vector<int> train_shapes, test_shapes;  // indices into the feature file
    /// Sum of the squares of what the training shapes differ by from what their codes decode to, as
    /// the scale counts features; none in files from before it was kept.
    std::optional<double> squared_error;

    /// The reference as files have it (V).
    const TriangleMesh& mesh() const {
        return places.are_all_vertices() ? reference : reference_of_files;
    }
    /// A mesh as files have it, from positions on the places (W): coincident vertices go together,
    /// those without a face stay where they are in the reference.
    TriangleMesh whole(std::span<const Point> positions) const;
};

/// Writes model, context, state of training and the codes of the training shapes as one atomic,
/// checked step. Throws IoError.
void write_model(const std::string& path, const LearnedModel& model, const ModelContext& context,
                 const TrainingState& state, const CodeTable& codes);

/// A model file opened for reading; its arrays are read into a model of the same configuration.
/// Every problem, truncation and altered bytes included, is a CheckpointError with the path.
class ModelFile {
  public:
    explicit ModelFile(const std::string& path);
    ModelFile(ModelFile&&) noexcept;
    ModelFile& operator=(ModelFile&&) noexcept;
    ~ModelFile();

    const std::string& path() const;
    /// What the file says its data hash to (XXH3).
    std::string data_hash() const;
    const ModelContext& context() const;
    const TrainingState& state() const;
    /// Codes of the training shapes.
    const CodeTable& codes() const;
    /// What training needs to go on, too; throws CheckpointError where the arrays do not fit.
    void load(LearnedModel& model) const;

  private:
    struct Content;
    std::unique_ptr<Content> content_;
};

}  // namespace mscomp
