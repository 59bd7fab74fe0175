// SPDX-License-Identifier: MIT
#include "config_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/nn/kinds.h"

namespace mscomp {
namespace {

constexpr Bounds kUnitRange{0, 1};
constexpr Bounds kNotNegative{0};
constexpr Bounds kAtLeastOne{1};

constexpr Bounds kPositive{.low = 0, .low_open = true};
constexpr Bounds kPositiveUpToOne{.low = 0, .high = 1, .low_open = true};

template <class Enum>
Choice choice(Enum& value, std::vector<std::pair<Enum, std::string>> values) {
    Choice result;
    for (const auto& [each, name] : values) result.names.push_back(name);
    result.get = [&value, values] {
        const auto found = std::find_if(values.begin(), values.end(),
                                        [&value](const auto& v) { return v.first == value; });
        return at(found - values.begin());
    };
    result.set = [&value, values](std::size_t index) { value = values[index].first; };
    return result;
}

Choice kind_choice(std::string& kind) {
    std::vector<std::pair<std::string, std::string>> kinds;
    for (const std::string& name : nn::model_kinds()) kinds.emplace_back(name, name);
    return choice(kind, std::move(kinds));
}

Choice activation_choice(nn::Activation& activation) {
    return choice(activation, {{nn::Activation::none, "none"}, {nn::Activation::tanh, "tanh"}});
}

Choice tied_choice(nn::Tied& tied) {
    using nn::Tied;
    return choice(tied,
                  {{Tied::transpose, "transpose"}, {Tied::same, "same"}, {Tied::none, "none"}});
}

/// Readings of the papers that a model of stacked autoencoders, one level or more, can take.
Table reading_keys(nn::StackedConfig& model) {
    return {
        {"tied",
         tied_choice(model.tied),
         {},
         "convolution of the decoder against that of the encoder"},
        {"latent_activation", activation_choice(model.latent_activation), {}, "on the codes"},
        {"decoder_fc_activation",
         activation_choice(model.decoder_fc_activation),
         {},
         "on what the codes decode to"},
    };
}

void append(Table& table, Table more) { std::ranges::move(more, std::back_inserter(table)); }

Table stacked_keys(nn::StackedConfig& model) {
    Table table{
        {"attention", &model.attention, {}, "false: one child that sees the whole residual"},
        {"joint", &model.joint, {}, "false: levels are trained separately"},
    };
    append(table, reading_keys(model));
    append(
        table,
        {{"mask_power", &model.mask_power, kPositive, "attention masks ~ a^p; the paper: 1"},
         {"mask_epsilon", &model.mask_epsilon, kPositive, "keeps masks defined where nothing acts"},
         {"levels", &model.levels, {}, "coarse to fine; each has a child per component above"}});
    return table;
}

Table autoencoder_keys(nn::StackedConfig& model) {
    Table table = level_table(model.levels.front());
    append(table, reading_keys(model));
    return table;
}

Table spectral_keys(nn::SpectralConfig& model) {
    using namespace nn;
    return {
        {"components", &model.components, kAtLeastOne, "latent dimension"},
        {"filter_order", &model.filter_order, Bounds{1, 16}, "of the Chebyshev convolutions"},
        {"conv_channels", &model.conv_channels, kAtLeastOne,
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

Table model_table(nn::Config& config) {
    Table table{{"kind", kind_choice(config.kind), {}, "what is trained"}};
    append(table, config.kind == "spectral-vae"  ? spectral_keys(config.spectral)
                  : config.kind == "autoencoder" ? autoencoder_keys(config.stacked)
                                                 : stacked_keys(config.stacked));
    return table;
}

Table stacked_loss_table(nn::LossConfig& loss) {
    return {
        {"reconstruction", &loss.reconstruction, kNotNegative, "squared feature error"},
        {"sparsity", &loss.sparsity, kNotNegative, "group sparsity outside the sparsity range"},
        {"range", &loss.range, kNotNegative, "keeps codes within the limit below"},
        {"range_limit", &loss.range_limit, kNotNegative, "codes above it are penalised"},
    };
}

Table spectral_loss_table(nn::SpectralLossConfig& loss) {
    return {
        {"reconstruction", &loss.reconstruction, kNotNegative, "squared feature error"},
        {"kl", &loss.kl, kNotNegative,
         "divergence of the codes from the normal distribution; the paper: 0.01"},
        {"sparsity", &loss.sparsity, kNotNegative, "group sparsity outside the sparsity ranges"},
        {"range", &loss.range, kNotNegative, "keeps codes within the limit below"},
        {"sparsity_range", &loss.sparsity_range, kNotNegative, "keeps the learned ranges small"},
        {"range_limit", &loss.range_limit, kNotNegative, "codes above it are penalised"},
    };
}

Table loss_table(nn::Config& config) {
    return config.kind == "spectral-vae" ? spectral_loss_table(config.spectral_loss)
                                         : stacked_loss_table(config.loss);
}

std::string loss_comment(const nn::Config& config) {
    if (config.kind == "spectral-vae") return "Weights of the loss.";
    if (config.kind == "autoencoder") return "Weights of the loss. The paper prints 1, 0.5, 0.5.";
    return "Weights of every autoencoder's loss. The paper prints 10, 1, 1: its components stay "
           "global.";
}

std::string model_comment(const nn::Config& config) {
    if (config.kind == "spectral-vae") return "Spectral variational autoencoder.";
    if (config.kind == "autoencoder") return "One localised autoencoder.";
    return "Stacked attention autoencoders.";
}

Table split_table(nn::SplitConfig& split) {
    using nn::SplitKind;
    return {
        {"train",
         choice(split.train, {{SplitKind::all, "all"},
                              {SplitKind::every, "every"},
                              {SplitKind::random, "random"},
                              {SplitKind::file, "file"}}),
         {},
         "which shapes train, the others test"},
        {"step", &split.step, kAtLeastOne, "every: shapes 0, step, 2 step, ..."},
        {"count", &split.count, kNotNegative, "random: how many"},
        {"seed", &split.seed, kNotNegative, "random: which"},
        {"path", &split.path, {}, "file: shape indices from 0, one per line"},
    };
}

Table data_table(nn::DataConfig& data) {
    using nn::Scale;
    using nn::Scaling;
    return {
        {"features", &data.features, {}, "from acapfeat extract; relative to this file"},
        {"split", split_table(data.split), {}, "Which shapes the model is trained on."},
        {"center",
         choice(data.center, {{Scaling::reference, "reference"}, {Scaling::minmax, "minmax"}}),
         {},
         "what maps to zero; minmax: the papers"},
        {"scale",
         choice(data.scale, {{Scale::shared, "shared"}, {Scale::separate, "separate"}}),
         {},
         "factors of rotation and stretch around the reference"},
    };
}

Table train_table(nn::TrainConfig& train) {
    using nn::SparsityStep;
    using nn::Start;
    return {
        {"epochs", &train.epochs, kAtLeastOne, "passes over the training shapes"},
        {"batch", &train.batch, kAtLeastOne, "shapes per step, at most all"},
        {"learning_rate", &train.learning_rate, kPositive,
         "of Adam, at the start; the papers: 0.001"},
        {"learning_rate_decay", &train.learning_rate_decay, kPositiveUpToOne, "factor per decay"},
        {"decay_steps", &train.decay_steps, kAtLeastOne, "steps between two decays"},
        {"learning_rate_floor", &train.learning_rate_floor, kNotNegative, "never below"},
        {"seed", &train.seed, kNotNegative, "of batches and of the random start"},
        {"start",
         choice(train.start, {{Start::deflation, "deflation"}, {Start::random, "random"}}),
         {},
         "first components: from the data or at random"},
        {"sparsity_step",
         choice(train.sparsity_step,
                {{SparsityStep::proximal, "proximal"}, {SparsityStep::subgradient, "subgradient"}}),
         {},
         "proximal: exact zeros; subgradient: the papers"},
        {"supports", &train.supports, {}, "leave out vertices where nothing acts: faster"},
        {"fill_up_to", &train.fill_up_to, kNotNegative,
         "fewer shapes are joined by locally mixed ones; 0: never"},
        {"plateau_epochs", &train.plateau_epochs, kNotNegative,
         "ends when so many epochs gain too little; 0: never"},
        {"plateau_gain", &train.plateau_gain, kUnitRange, "part of the error that is too little"},
        {"checkpoint_every", &train.checkpoint_every, kAtLeastOne, "epochs; the last always"},
    };
}

Table filter_table(nn::FilterConfig& filter) {
    return {
        {"minimum_strength", &filter.minimum_strength, kNotNegative, "weaker ones are dropped"},
        {"relative_threshold", &filter.relative_threshold, kUnitRange,
         "part of the peak from which a vertex counts"},
        {"absolute_threshold", &filter.absolute_threshold, kNotNegative,
         "> 0 replaces the relative one; the paper: 1.0e-6"},
    };
}

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
        text += names[i];
    }
    return text;
}

std::string within(const std::string& kind, const Bounds& bounds) {
    if (std::isinf(bounds.low)) return kind;
    const std::string_view sign = bounds.low_open ? ">" : ">=";
    if (std::isinf(bounds.high)) return fmt::format("{} {} {}", kind, sign, bounds.low);
    return fmt::format("{} {} {} and <= {}", kind, sign, bounds.low, bounds.high);
}

struct Wanted {
    const Bounds& bounds;
    std::string operator()(const bool*) const { return "true or false"; }
    std::string operator()(const int*) const { return within("a whole number", bounds); }
    std::string operator()(const std::uint64_t*) const { return within("a whole number", bounds); }
    std::string operator()(const double*) const { return within("a number", bounds); }
    std::string operator()(const std::string*) const { return "a file name"; }
    std::string operator()(const Choice& field) const { return listed(field.names); }
    std::string operator()(const std::optional<double>*) const {
        return within("a number", bounds) + ", or null";
    }
    std::string operator()(const std::optional<nn::SparsityRamp>*) const {
        return "[from, to] with 0 <= from < to <= 1, or null";
    }
    std::string operator()(const std::vector<nn::LevelConfig>*) const {
        return "a list of at least one level {components, sparsity_range}";
    }
    std::string operator()(const Table& table) const {
        std::vector<std::string> names;
        for (const Key& key : table) names.push_back(key.name);
        return fmt::format("a mapping with the keys {}", fmt::join(names, ", "));
    }
};

}  // namespace

Table config_table(nn::Config& config) {
    return {
        {"model", model_table(config), {}, model_comment(config)},
        {"loss", loss_table(config), {}, loss_comment(config)},
        {"data", data_table(config.data), {}, "What it is trained on."},
        {"train", train_table(config.train), {}, "How it is trained."},
        {"filter",
         filter_table(config.filter),
         {},
         "Which components are worth keeping, in unscaled features."},
    };
}

Table level_table(nn::LevelConfig& level) {
    return {
        {"components", &level.components, kAtLeastOne, "of each autoencoder", true},
        {"sparsity_range", &level.sparsity_range, kUnitRange, "geodesic radius, diameter = 1",
         true},
        {"max_support", &level.max_support, kPositiveUpToOne,
         "part of the vertices it may act on; null: the range, the papers: 1"},
        {"sparsity_ramp", &level.sparsity_ramp, {}, "instead of a step at the range"},
    };
}

std::string wanted(const Key& key) { return std::visit(Wanted{key.bounds}, key.field); }

}  // namespace mscomp
