// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/config.h"
#include "nn/model.h"

namespace mscomp::nn {

/// Names of the model kinds that can be trained; the first is the one taken by default.
std::vector<std::string> model_kinds();

/// The recommended configuration of a kind, without features. Throws UsageError listing the kinds.
Config default_config(const std::string& kind);

/// Whether the model takes weights of the edges: the cotangents of the reference.
bool wants_edge_weights(const Config& config);

enum class ModelUse {
    training,
    reading  // encodes and decodes only; asks for no distances
};

/// An untrained model of the configured kind for batches of at most `batch` shapes of a mesh with
/// these one-rings; `edge_weights` beside rings.neighbors if it wants them, else none. Borrows
/// `distances`. Throws UsageError for an unknown kind.
std::unique_ptr<Model<float>> make_model(const Config& config, const OneRings& rings,
                                         std::span<const double> edge_weights,
                                         DistanceRows& distances, ModelUse use, int batch);

}  // namespace mscomp::nn
