// SPDX-License-Identifier: MIT
// The kinds of stacked autoencoders: with attention on levels [A], and with one level the AAAI-18
// predecessor.
#include <fmt/format.h>

#include <cstdint>
#include <memory>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/model/counts.h"
#include "mscomp/nn/kinds.h"
#include "nn/network.h"
#include "nn/network_kinds.h"
#include "nn/stacked_model.h"

namespace mscomp::nn {
namespace {

IntervalField ramp_field(std::optional<SparsityRamp>& ramp) {
    return {[&ramp]() -> IntervalField::Interval {
                if (!ramp) return std::nullopt;
                return std::pair{ramp->from, ramp->to};
            },
            [&ramp](const IntervalField::Interval& value) {
                ramp.reset();
                if (value) ramp = SparsityRamp{value->first, value->second};
            }};
}

Table level_keys(LevelConfig& level) {
    return {
        {"components", &level.components, kComponentCount, "of each autoencoder", true},
        {"sparsity_range", &level.sparsity_range, kUnitRange, "geodesic radius, diameter = 1",
         true},
        {"max_support", &level.max_support, kPositiveUpToOne,
         "part of the vertices it may act on; null: the range, the papers: 1"},
        {"sparsity_ramp", ramp_field(level.sparsity_ramp), {}, "instead of a step at the range"},
    };
}

List levels_field(std::vector<LevelConfig>& levels) {
    return {"level", [&levels] { return levels.size(); },
            [&levels](std::size_t count) { levels.assign(count, LevelConfig{}); },
            [&levels](std::size_t index) { return level_keys(levels[index]); },
            [] {
                static LevelConfig any;
                return level_keys(any);
            }};
}

Choice activation_choice(Activation& activation) {
    return choice(activation, {{Activation::none, "none"}, {Activation::tanh, "tanh"}});
}

/// Readings of the papers that a model of stacked autoencoders, one level or more, can take.
Table reading_keys(StackedConfig& model) {
    return {
        {"tied",
         tied_choice(model.tied),
         {},
         "convolution of the decoder against that of the encoder"},
        {"bias", &model.bias, {}, "of the convolutions; false: the reference comes back exactly"},
        {"latent_activation", activation_choice(model.latent_activation), {}, "on the codes"},
        {"decoder_fc_activation",
         activation_choice(model.decoder_fc_activation),
         {},
         "on what the codes decode to"},
    };
}

Table stacked_keys(StackedConfig& model) {
    Table table{
        {"attention", &model.attention, {}, "false: one child that sees the whole residual"},
        {"joint", &model.joint, {}, "false: levels are trained separately"},
    };
    append(table, reading_keys(model));
    append(
        table,
        {{"mask_power", &model.mask_power, kPositive, "attention masks ~ a^p; the paper: 1"},
         {"mask_epsilon", &model.mask_epsilon, kPositive, "keeps masks defined where nothing acts"},
         {"levels",
          levels_field(model.levels),
          {},
          "coarse to fine; each has a child per component above"}});
    return table;
}

Table autoencoder_keys(StackedConfig& model) {
    Table table = level_keys(model.levels.front());
    append(table, reading_keys(model));
    return table;
}

Table loss_keys(LossConfig& loss) {
    return {
        {"reconstruction", &loss.reconstruction, kNotNegative, "squared feature error"},
        {"sparsity", &loss.sparsity, kNotNegative, "group sparsity outside the sparsity range"},
        {"range", &loss.range, kNotNegative, "keeps codes within the limit below"},
        {"range_limit", &loss.range_limit, kNotNegative,
         "codes above it are penalised; null: 5, more beyond 10,000 vertices; the papers: 5"},
    };
}

Table stacked_loss_keys(LossConfig& loss) {
    Table table{
        {"target",
         choice(loss.target, {{LossTarget::sum, "sum"}, {LossTarget::share, "share"}}),
         {},
         "of levels beyond the first: the shape by the sum of all levels; the paper: share"}};
    append(table, loss_keys(loss));
    return table;
}

KindKeys stacked_attention_keys(Config& config) {
    auto& own = config.own<StackedSettings>();
    return {"Stacked attention autoencoders.", stacked_keys(own.model),
            "Weights of every autoencoder's loss. The paper prints 10, 1, 1: its components stay "
            "global.",
            stacked_loss_keys(own.loss), network_train_keys(config.train)};
}

KindKeys autoencoder_kind_keys(Config& config) {
    auto& own = config.own<StackedSettings>();
    return {"One localised autoencoder.", autoencoder_keys(own.model),
            "Weights of the loss. The paper prints 1, 0.5, 0.5.", loss_keys(own.loss),
            network_train_keys(config.train)};
}

/// With attention every component of a level has an autoencoder of its own on the next, so levels
/// multiply.
void require_few_components(const StackedConfig& model) {
    constexpr std::int64_t kMost = 100'000;
    std::int64_t autoencoders = 1;
    for (const LevelConfig& level : model.levels) {
        const std::int64_t components = autoencoders * level.components;
        if (model.attention) autoencoders = components;
        if (components <= kMost) continue;
        throw UsageError(fmt::format("model.levels: {} components on one level, wanted at most {}",
                                     components, kMost));
    }
}

std::unique_ptr<LearnedModel> make_stacked(const Config& config, const ModelPlace& place) {
    auto options = options_for<StackedModel<float>::Options>(config, place);
    options.supports = place.use == ModelUse::reading || config.train.supports;
    auto own = config.own<StackedSettings>();
    // The reference is at zero only with center: reference.
    own.model.bias |= config.data.center == Scaling::minmax;
    require_few_components(own.model);
    auto model = std::make_unique<StackedModel<float>>(
        own.model, own.loss,
        one_rings_of_faces(place.reference.vertex_count(), place.reference.faces), place.distances,
        options);
    return std::make_unique<Network>(std::move(model), place.scale, config.train);
}

void stacked_defaults(Config& config) {
    config.settings = StackedSettings{};
    config.data.metric = FeatureMetric::area;
}

void autoencoder_defaults(Config& config) {
    StackedSettings settings;
    settings.model.levels = {{50, 0.25, {}, {}}};
    settings.model.bias = true;
    config.settings = settings;
}

}  // namespace

Kind stacked_attention() {
    return {"stacked-attention", always_features, stacked_defaults, stacked_attention_keys,
            make_stacked};
}

Kind autoencoder() {
    return {"autoencoder", always_features, autoencoder_defaults, autoencoder_kind_keys,
            make_stacked};
}

}  // namespace mscomp::nn
