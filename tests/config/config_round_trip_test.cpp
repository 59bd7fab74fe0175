// SPDX-License-Identifier: MIT
// What is written reads back as what it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "config/config_cases.h"
#include "mscomp/config/config_file.h"
#include "mscomp/kinds/kinds.h"

namespace mscomp {
namespace {

Config config_with_no_default() {
    Config c = default_config("stacked-attention");
    stacked(c).model.attention = false;
    stacked(c).model.joint = false;
    stacked(c).model.tied = nn::Tied::none;
    stacked(c).model.latent_activation = nn::Activation::tanh;
    stacked(c).model.decoder_fc_activation = nn::Activation::tanh;
    stacked(c).model.bias = true;
    stacked(c).model.mask_power = 4.25;
    stacked(c).model.mask_epsilon = 3e-9;
    stacked(c).model.levels.resize(3);
    stacked(c).model.levels[0].components = 7;
    stacked(c).model.levels[0].sparsity_range = 0.1 + 0.2;
    stacked(c).model.levels[0].max_support = 1.0 / 7;
    stacked(c).model.levels[0].sparsity_ramp = nn::SparsityRamp{0.125, 1.0 / 3};
    stacked(c).model.levels[1].components = 1;
    stacked(c).model.levels[1].sparsity_range = 0;
    stacked(c).model.levels[2].components = 3;
    stacked(c).model.levels[2].sparsity_range = 1;
    stacked(c).loss.reconstruction = 10;
    stacked(c).loss.sparsity = 0.1;
    stacked(c).loss.range = 1e-7;
    stacked(c).loss.range_limit = 123456.789;
    stacked(c).loss.target = nn::LossTarget::share;
    c.data.features = "a folder/odd \"name\": #1.safetensors";
    c.data.split.train = SplitKind::random;
    c.data.split.step = 3;
    c.data.split.count = 36;
    c.data.split.seed = 18446744073709551615u;
    c.data.split.path = "null";
    c.data.center = Scaling::minmax;
    c.data.scale = Scale::robust;
    c.data.metric = FeatureMetric::vertices;
    c.train.epochs = 1;
    c.train.batch = 1000000000;
    c.train.learning_rate = 1e-300;
    c.train.learning_rate_decay = 1;
    c.train.decay_steps = 5;
    c.train.learning_rate_floor = 0;
    c.train.seed = 1ull << 63;
    c.train.start = Start::random;
    c.train.sparsity_step = SparsityStep::subgradient;
    c.train.supports = false;
    c.train.fill_up_to = 7;
    c.train.fill_below = 5;
    c.train.plateau_epochs = 3;
    c.train.plateau_gain = 0.375;
    c.train.checkpoint_every = 9;
    c.filter.rule = FilterRule::strength;
    c.filter.refit_share = 0.0625;
    c.filter.alike = 0.875;
    c.filter.minimum_strength = 1e-3;
    c.filter.minimum_share = 0.125;
    c.filter.relative_threshold = 1;
    c.filter.absolute_threshold = 1e-6;
    return c;
}

// read(write(c)) = c, field by field, for a configuration that differs from the defaults
// everywhere.
TEST(ConfigRoundTrip, WritingThenReadingIsTheIdentity) {
    const Config c = config_with_no_default();
    for (const bool with_comments : {false, true}) {
        const Config r = parse_config(write_config(c, with_comments), "c.yaml");
        EXPECT_EQ(r.kind, c.kind);
        EXPECT_EQ(stacked(r).model.attention, stacked(c).model.attention);
        EXPECT_EQ(stacked(r).model.joint, stacked(c).model.joint);
        EXPECT_EQ(stacked(r).model.tied, stacked(c).model.tied);
        EXPECT_EQ(stacked(r).model.latent_activation, stacked(c).model.latent_activation);
        EXPECT_EQ(stacked(r).model.decoder_fc_activation, stacked(c).model.decoder_fc_activation);
        EXPECT_EQ(stacked(r).model.bias, stacked(c).model.bias);
        EXPECT_EQ(stacked(r).model.mask_power, stacked(c).model.mask_power);
        EXPECT_EQ(stacked(r).model.mask_epsilon, stacked(c).model.mask_epsilon);
        ASSERT_EQ(stacked(r).model.levels.size(), stacked(c).model.levels.size());
        for (std::size_t i = 0; i < stacked(c).model.levels.size(); ++i) {
            EXPECT_EQ(stacked(r).model.levels[i].components, stacked(c).model.levels[i].components);
            EXPECT_EQ(stacked(r).model.levels[i].sparsity_range,
                      stacked(c).model.levels[i].sparsity_range);
            EXPECT_EQ(stacked(r).model.levels[i].max_support,
                      stacked(c).model.levels[i].max_support);
            EXPECT_EQ(stacked(r).model.levels[i].sparsity_ramp.has_value(),
                      stacked(c).model.levels[i].sparsity_ramp.has_value());
        }
        EXPECT_EQ(stacked(r).model.levels[0].sparsity_ramp->from,
                  stacked(c).model.levels[0].sparsity_ramp->from);
        EXPECT_EQ(stacked(r).model.levels[0].sparsity_ramp->to,
                  stacked(c).model.levels[0].sparsity_ramp->to);
        EXPECT_EQ(stacked(r).loss.reconstruction, stacked(c).loss.reconstruction);
        EXPECT_EQ(stacked(r).loss.sparsity, stacked(c).loss.sparsity);
        EXPECT_EQ(stacked(r).loss.range, stacked(c).loss.range);
        EXPECT_EQ(stacked(r).loss.range_limit, stacked(c).loss.range_limit);
        EXPECT_EQ(stacked(r).loss.target, stacked(c).loss.target);
        EXPECT_EQ(r.data.features, c.data.features);
        EXPECT_EQ(r.data.split.train, c.data.split.train);
        EXPECT_EQ(r.data.split.step, c.data.split.step);
        EXPECT_EQ(r.data.split.count, c.data.split.count);
        EXPECT_EQ(r.data.split.seed, c.data.split.seed);
        EXPECT_EQ(r.data.split.path, c.data.split.path);
        EXPECT_EQ(r.data.center, c.data.center);
        EXPECT_EQ(r.data.scale, c.data.scale);
        EXPECT_EQ(r.data.metric, c.data.metric);
        EXPECT_EQ(r.train.epochs, c.train.epochs);
        EXPECT_EQ(r.train.batch, c.train.batch);
        EXPECT_EQ(r.train.learning_rate, c.train.learning_rate);
        EXPECT_EQ(r.train.learning_rate_decay, c.train.learning_rate_decay);
        EXPECT_EQ(r.train.decay_steps, c.train.decay_steps);
        EXPECT_EQ(r.train.learning_rate_floor, c.train.learning_rate_floor);
        EXPECT_EQ(r.train.seed, c.train.seed);
        EXPECT_EQ(r.train.start, c.train.start);
        EXPECT_EQ(r.train.sparsity_step, c.train.sparsity_step);
        EXPECT_EQ(r.train.supports, c.train.supports);
        EXPECT_EQ(r.train.fill_up_to, c.train.fill_up_to);
        EXPECT_EQ(r.train.fill_below, c.train.fill_below);
        EXPECT_EQ(r.train.plateau_epochs, c.train.plateau_epochs);
        EXPECT_EQ(r.train.plateau_gain, c.train.plateau_gain);
        EXPECT_EQ(r.train.checkpoint_every, c.train.checkpoint_every);
        EXPECT_EQ(r.filter.rule, c.filter.rule);
        EXPECT_EQ(r.filter.refit_share, c.filter.refit_share);
        EXPECT_EQ(r.filter.alike, c.filter.alike);
        EXPECT_EQ(r.filter.minimum_strength, c.filter.minimum_strength);
        EXPECT_EQ(r.filter.minimum_share, c.filter.minimum_share);
        EXPECT_EQ(r.filter.relative_threshold, c.filter.relative_threshold);
        EXPECT_EQ(r.filter.absolute_threshold, c.filter.absolute_threshold);
    }
}

// Guards the test above: a key that is added to the table has to be added to it, too.
TEST(ConfigRoundTrip, TheExampleDiffersFromTheDefaultsInEveryKeyButTheKind) {
    Config c = config_with_no_default();
    stacked(c).model.levels.resize(2);
    stacked(c).model.levels[1] = {3, 1, 0.5, nn::SparsityRamp{0, 1}};
    std::istringstream example(all_of(c)), defaults(all_of(default_config("stacked-attention")));
    std::string line, default_line;
    while (std::getline(example, line) && std::getline(defaults, default_line)) {
        const bool is_section = line.ends_with(':');
        if (is_section || line == "  kind: stacked-attention") continue;
        EXPECT_NE(line, default_line);
    }
    EXPECT_FALSE(std::getline(defaults, default_line));
}

TEST(ConfigRoundTrip, InitReadsBackAsTheDefaults) {
    Config defaults = default_config("stacked-attention");
    defaults.data.features = "features.safetensors";
    const std::string text = config_template("stacked-attention");
    EXPECT_EQ(all_of(parse_config(text, "c.yaml")), all_of(defaults));
}

// read(write(c)) = c for the other kinds, seen through what is written: no field has its default.
TEST(ConfigRoundTrip, WhatOtherKindsWriteReadsBack) {
    Config vae = default_config("spectral-vae");
    spectral(vae).model = {7,
                           5,
                           6,
                           nn::Tied::none,
                           nn::Adjacency::cotangent,
                           nn::LambdaMax::exact,
                           nn::Spread::linear,
                           0.25,
                           1e-5,
                           nn::StraightThrough::identity,
                           nn::RangeTerm::l2,
                           false,
                           0.375};
    spectral(vae).loss = {2, 3, 4, 5, 6, 7};
    Config one = default_config("autoencoder");
    stacked(one).model.levels = {{9, 0.125, 0.5, nn::SparsityRamp{0.25, 0.75}}};
    stacked(one).model.tied = nn::Tied::none;
    stacked(one).model.bias = false;
    stacked(one).model.latent_activation = nn::Activation::tanh;
    stacked(one).model.decoder_fc_activation = nn::Activation::tanh;
    stacked(one).loss = {2, 3, 4, 6};
    vae.data.features = one.data.features = "features.safetensors";
    for (const Config& c : {vae, one}) {
        const std::string text = all_of(c);
        EXPECT_EQ(all_of(parse_config(text, "c.yaml")), text);
        EXPECT_EQ(all_of(parse_config(write_config(c, true), "c.yaml")), text);
        const std::string defaults = all_of(default_config(c.kind));
        std::istringstream lines(text), default_lines(defaults);
        std::string line, default_line;
        bool in_model_or_loss = false;
        while (std::getline(lines, line) && std::getline(default_lines, default_line)) {
            if (!line.starts_with(" ")) {
                in_model_or_loss = line.starts_with("model") || line.starts_with("loss");
            } else if (in_model_or_loss && line.find("kind:") == std::string::npos) {
                EXPECT_NE(line, default_line);
            }
        }
    }
}

TEST(ConfigRoundTrip, EveryKeyIsPrintedWithAComment) {
    const std::string text = config_template("stacked-attention");
    for (const char* key : {"kind",
                            "attention",
                            "joint",
                            "tied",
                            "latent_activation",
                            "decoder_fc_activation",
                            "mask_power",
                            "mask_epsilon",
                            "levels",
                            "components",
                            "sparsity_range",
                            "sparsity_ramp",
                            "reconstruction",
                            "sparsity",
                            "range",
                            "range_limit",
                            "features",
                            "step",
                            "count",
                            "seed",
                            "path",
                            "center",
                            "scale",
                            "epochs",
                            "batch",
                            "learning_rate",
                            "learning_rate_decay",
                            "decay_steps",
                            "learning_rate_floor",
                            "start",
                            "sparsity_step",
                            "supports",
                            "fill_up_to",
                            "plateau_epochs",
                            "plateau_gain",
                            "checkpoint_every",
                            "minimum_strength",
                            "relative_threshold",
                            "absolute_threshold"}) {
        EXPECT_THAT(text, testing::ContainsRegex(std::string("[ -] ") + key + ": *[^#\n]*# "));
    }
}

}  // namespace
}  // namespace mscomp
