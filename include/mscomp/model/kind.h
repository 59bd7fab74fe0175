// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/model/config.h"
#include "mscomp/model/keys.h"
#include "mscomp/model/learned_model.h"

namespace mscomp {

enum class ModelUse {
    training,
    reading  // encodes and decodes only; asks for no distances
};

/// What a model is made for. Mesh and distances are borrowed as long as the model lives.
struct ModelPlace {
    const TriangleMesh& reference;
    DistanceRows& distances;  // normalised
    MetricScale scale;        // of features, fitted on the training shapes
    ModelUse use = ModelUse::reading;
    /// How many shapes a model for training is trained on, and of one for reading the most that are
    /// worth encoding together.
    int shapes = 1;
    /// Cotangent weights beside the neighbours of one_rings_of_faces, for who asks.
    std::function<std::vector<double>()> edge_weights = {};
    std::string weights = "cotangent";  // edge weights that the features were made with
};

/// The keys of a kind, bound to the fields of a configuration.
struct KindKeys {
    std::string model_comment;
    Table model;  // beside model.kind
    std::string loss_comment;
    Table loss;   // no section where empty
    Table train;  // likewise
};

inline ShapeRows always_features(const Config& /*config*/) { return ShapeRows::features; }
inline ShapeRows always_positions(const Config& /*config*/) { return ShapeRows::positions; }

/// A method that finds components: everything that the configuration, training and all commands
/// need to know of it.
struct Kind {
    std::string name;  // model.kind
    /// What codes decode to, where a kind leaves that to its settings.
    ShapeRows (*rows)(const Config& config) = always_features;
    /// What differs from Config{}, its own settings first of all.
    void (*set_defaults)(Config& config) = nullptr;
    /// `config` has settings of this kind and outlives the keys.
    KindKeys (*keys)(Config& config) = nullptr;
    /// An untrained model.
    std::unique_ptr<LearnedModel> (*make)(const Config& config, const ModelPlace& place) = nullptr;
    bool has_center = true;  // of features: whether data.center may be anything but the reference
};

}  // namespace mscomp
