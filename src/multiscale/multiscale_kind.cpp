// SPDX-License-Identifier: MIT
#include <memory>

#include "mscomp/model/counts.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/multiscale_model.h"

namespace mscomp {
namespace {

Table level_keys(BallLevel& level) {
    return {
        {"components", &level.components, kComponentCount, "of the level", true},
        {"sparsity_range", &level.sparsity_range, kUnitRange, "geodesic radius, diameter = 1",
         true},
        {"max_support", &level.max_support, kPositiveUpToOne,
         "part of the vertices it may act on at most", true},
    };
}

List levels_field(std::vector<BallLevel>& levels) {
    return {"level", [&levels] { return levels.size(); },
            [&levels](std::size_t count) { levels.assign(count, BallLevel{}); },
            [&levels](std::size_t index) { return level_keys(levels[index]); },
            [] {
                static BallLevel any;
                return level_keys(any);
            }};
}

Table spread_keys(CenterSpread& spread) {
    return {
        {"most", &spread.most, kCount, "centres within the radius"},
        {"radius", &spread.radius, kUnitRange, "geodesic, diameter = 1"},
    };
}

KindKeys keys(Config& config) {
    auto& own = config.own<MultiscaleSettings>();
    return {
        "Components fitted to the shapes.",
        {{"global_components", &own.global_components, Bounds{0, 10'000},
          "first ones without a limit to their support"},
         {"levels", levels_field(own.levels), {}, "coarse to fine, all of them are summed"},
         {"spread", spread_keys(own.spread), {}, "Centres do not pile up."},
         {"damping", &own.damping, kNotNegative,
          "of the components' least squares, towards the mean of the neighbours"},
         {"feature_share", &own.feature_share, kNotNegative,
          "what the error of features counts beside that in space"}},
        "",
        {},
        {{"epochs", &config.train.epochs, kCount, "of both stages"},
         {"rounds", &own.rounds, kCountOrNone,
          "first epochs, of alternating least squares; the others lower the error in space"},
         {"start",
          &config.train.start_run,
          {},
          "a run whose components are begun with; empty: found in the shapes"},
         {"mirror",
          &own.mirror,
          {},
          "learn from mirror images, too, where the reference is symmetric"},
         {"select",
          &own.select,
          {},
          "few shapes decide by cross-validation about global components and mixed shapes"},
         {"seed", &config.train.seed, kNotNegative, "of mixed shapes"},
         {"fill_up_to", &config.train.fill_up_to, Bounds{0, kMostFilledUpTo},
          "few shapes are joined by locally mixed ones; 0: never"},
         {"between", &own.between, kUnitRange,
          "part of their patches that lie between two shapes, or a little beyond"},
         {"checkpoint_every", &config.train.checkpoint_every, kCount, "epochs; the last always"}}};
}

void set_defaults(Config& config) {
    config.settings = MultiscaleSettings{};
    config.data.metric = FeatureMetric::area;
    config.train.epochs = 34;
    config.train.plateau_epochs = 0;
    config.train.fill_up_to = 48;
    config.train.checkpoint_every = 5;
}

std::unique_ptr<LearnedModel> make(const Config& config, const ModelPlace& place) {
    return std::make_unique<MultiscaleModel>(config, place);
}

}  // namespace

Kind multiscale() { return {"multiscale", always_features, set_defaults, keys, make, false}; }

}  // namespace mscomp
