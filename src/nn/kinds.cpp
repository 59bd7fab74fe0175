// SPDX-License-Identifier: MIT
#include "mscomp/nn/kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "mscomp/base/error.h"
#include "nn/spectral_vae.h"
#include "nn/stacked_model.h"

namespace mscomp::nn {
namespace {

/// What a model is made from.
struct Making {
    const Config& config;
    const OneRings& rings;
    std::span<const double> edge_weights;
    DistanceRows& distances;
    ModelUse use;
    int batch;
};

template <class Options>
Options options_of(const Making& making) {
    Options options;
    options.batch = making.batch;
    options.losses = making.use == ModelUse::training;
    options.sparsity_gradient = making.use == ModelUse::training &&
                                making.config.train.sparsity_step == SparsityStep::subgradient;
    return options;
}

std::unique_ptr<Model<float>> make_stacked(const Making& making) {
    auto options = options_of<StackedModel<float>::Options>(making);
    options.supports = making.use == ModelUse::reading || making.config.train.supports;
    return std::make_unique<StackedModel<float>>(making.config.stacked, making.config.loss,
                                                 making.rings, making.distances, options);
}

std::unique_ptr<Model<float>> make_spectral(const Making& making) {
    return std::make_unique<SpectralVae<float>>(making.config.spectral, making.config.spectral_loss,
                                                making.rings, making.edge_weights, making.distances,
                                                options_of<SpectralVae<float>::Options>(making));
}

/// The AAAI-18 predecessor: one level (method §3).
void autoencoder_defaults(Config& config) { config.stacked.levels = {{50, 0.25, {}, {}}}; }

void keep_defaults(Config&) {}

struct Kind {
    const char* name;
    void (*set_defaults)(Config&);
    std::unique_ptr<Model<float>> (*make)(const Making&);
};

constexpr std::array<Kind, 3> kKinds{{
    {"stacked-attention", keep_defaults, make_stacked},
    {"autoencoder", autoencoder_defaults, make_stacked},
    {"spectral-vae", keep_defaults, make_spectral},
}};

const Kind& kind_of(const std::string& name) {
    const auto* found = std::ranges::find_if(kKinds, [&](const Kind& k) { return k.name == name; });
    if (found != kKinds.end()) return *found;
    throw UsageError(fmt::format("unknown model kind \"{}\"; known kinds: {}", name,
                                 fmt::join(model_kinds(), ", ")));
}

}  // namespace

std::vector<std::string> model_kinds() {
    std::vector<std::string> names;
    for (const Kind& kind : kKinds) names.emplace_back(kind.name);
    return names;
}

Config default_config(const std::string& kind) {
    Config config;
    config.kind = kind;
    kind_of(kind).set_defaults(config);
    return config;
}

bool wants_edge_weights(const Config& config) {
    return config.kind == "spectral-vae" && config.spectral.adjacency == Adjacency::cotangent;
}

std::unique_ptr<Model<float>> make_model(const Config& config, const OneRings& rings,
                                         std::span<const double> edge_weights,
                                         DistanceRows& distances, ModelUse use, int batch) {
    return kind_of(config.kind).make({config, rings, edge_weights, distances, use, batch});
}

}  // namespace mscomp::nn
