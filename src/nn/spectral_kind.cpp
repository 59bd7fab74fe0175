// SPDX-License-Identifier: MIT
// The spectral variational autoencoder [B] as a kind.
#include <memory>

#include "mscomp/model/counts.h"
#include "mscomp/nn/kinds.h"
#include "mscomp/nn/spectral_config.h"
#include "nn/network.h"
#include "nn/network_kinds.h"
#include "nn/spectral_vae.h"

namespace mscomp::nn {
namespace {

Table spectral_keys(SpectralConfig& model) {
    return {
        {"components", &model.components, kComponentCount, "latent dimension"},
        {"filter_order", &model.filter_order, Bounds{1, 16}, "of the Chebyshev convolutions"},
        {"conv_channels", &model.conv_channels, Bounds{1, 1024},
         "per vertex behind the convolution; other than 9: a decoder of its own"},
        {"tied", tied_choice(model.tied), {}, "filters of the decoder; same: the paper"},
        {"adjacency",
         choice(model.adjacency,
                {{Adjacency::binary, "binary"}, {Adjacency::cotangent, "cotangent"}}),
         {},
         "weights of the edges"},
        {"lambda_max",
         choice(model.lambda_max, {{LambdaMax::two, "two"}, {LambdaMax::exact, "exact"}}),
         {},
         "largest eigenvalue: its bound 2, or computed"},
        {"sigma",
         choice(model.spread, {{Spread::log_variance, "log_variance"}, {Spread::linear, "linear"}}),
         {},
         "what the second projection is; linear: as printed"},
        {"sigma_offset",
         &model.spread_offset,
         {},
         "added to it; null: where noise balances divergence, the paper: 0"},
        {"kl_epsilon", &model.kl_epsilon, kNotNegative, "inside the logarithm of a linear sigma"},
        {"straight_through",
         choice(model.straight_through,
                {{StraightThrough::outside, "outside"}, {StraightThrough::identity, "identity"}}),
         {},
         "where learned ranges have a slope"},
        {"range_penalty",
         choice(model.range_term, {{RangeTerm::sum, "sum"}, {RangeTerm::l2, "l2"}}),
         {},
         "of the learned ranges; l2: as printed"},
        {"learned_range", &model.learned_range, {}, "false: ranges stay as they start"},
        {"initial_range", &model.initial_range, kUnitRange, "geodesic radius, diameter = 1"},
    };
}

Table loss_keys(SpectralLossConfig& loss) {
    return {
        {"reconstruction", &loss.reconstruction, kNotNegative, "squared feature error"},
        {"kl", &loss.kl, kNotNegative,
         "divergence of the codes from the normal distribution; the paper: 0.01"},
        {"sparsity", &loss.sparsity, kNotNegative, "group sparsity outside the sparsity ranges"},
        {"range", &loss.range, kNotNegative, "keeps codes within the limit below"},
        {"sparsity_range", &loss.sparsity_range, kNotNegative, "keeps the learned ranges small"},
        {"range_limit", &loss.range_limit, kNotNegative,
         "codes above it are penalised; null: 5, more beyond 10,000 vertices; the papers: 5"},
    };
}

KindKeys keys(Config& config) {
    auto& own = config.own<SpectralSettings>();
    return {"Spectral variational autoencoder.", spectral_keys(own.model), "Weights of the loss.",
            loss_keys(own.loss), network_train_keys(config.train)};
}

std::unique_ptr<LearnedModel> make(const Config& config, const ModelPlace& place) {
    const auto& own = config.own<SpectralSettings>();
    std::vector<double> weights;
    if (own.model.adjacency == Adjacency::cotangent) weights = place.edge_weights();
    auto model = std::make_unique<SpectralVae<float>>(
        own.model, own.loss,
        one_rings_of_faces(place.reference.vertex_count(), place.reference.faces), weights,
        place.distances, options_for<SpectralVae<float>::Options>(config, place));
    return std::make_unique<Network>(std::move(model), place.scale, config.train,
                                     Network::Prior::normal);
}

void set_defaults(Config& config) {
    config.settings = SpectralSettings{};
    config.train.fill_below = 24;
}

}  // namespace

Kind spectral_vae() { return {"spectral-vae", always_features, set_defaults, keys, make}; }

}  // namespace mscomp::nn
