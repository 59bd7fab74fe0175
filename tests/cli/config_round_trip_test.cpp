// SPDX-License-Identifier: MIT
// What is written reads back as what it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "mscomp/cli/config_file.h"

namespace mscomp {
namespace {

// Every field of a configuration, so that equality misses none of those the table has.
std::string all_of(const nn::Config& config) { return write_config(config, false); }

nn::Config config_with_no_default() {
    nn::Config c;
    c.stacked.attention = false;
    c.stacked.joint = false;
    c.stacked.tied = nn::Tied::none;
    c.stacked.latent_activation = nn::Activation::tanh;
    c.stacked.decoder_fc_activation = nn::Activation::tanh;
    c.stacked.mask_power = 4.25;
    c.stacked.mask_epsilon = 3e-9;
    c.stacked.levels.resize(3);
    c.stacked.levels[0].components = 7;
    c.stacked.levels[0].sparsity_range = 0.1 + 0.2;
    c.stacked.levels[0].max_support = 1.0 / 7;
    c.stacked.levels[0].sparsity_ramp = nn::SparsityRamp{0.125, 1.0 / 3};
    c.stacked.levels[1].components = 1;
    c.stacked.levels[1].sparsity_range = 0;
    c.stacked.levels[2].components = 3;
    c.stacked.levels[2].sparsity_range = 1;
    c.loss.reconstruction = 10;
    c.loss.sparsity = 0.1;
    c.loss.range = 1e-7;
    c.loss.range_limit = 123456.789;
    c.data.features = "a folder/odd \"name\": #1.safetensors";
    c.data.split.train = nn::SplitKind::random;
    c.data.split.step = 3;
    c.data.split.count = 36;
    c.data.split.seed = 18446744073709551615u;
    c.data.split.path = "null";
    c.data.center = nn::Scaling::minmax;
    c.data.scale = nn::Scale::separate;
    c.train.epochs = 1;
    c.train.batch = 2147483647;
    c.train.learning_rate = 1e-300;
    c.train.learning_rate_decay = 1;
    c.train.decay_steps = 5;
    c.train.learning_rate_floor = 0;
    c.train.seed = 1ull << 63;
    c.train.start = nn::Start::random;
    c.train.sparsity_step = nn::SparsityStep::subgradient;
    c.train.supports = false;
    c.train.fill_up_to = 7;
    c.train.plateau_epochs = 3;
    c.train.plateau_gain = 0.375;
    c.train.checkpoint_every = 9;
    c.filter.minimum_strength = 1e-3;
    c.filter.relative_threshold = 1;
    c.filter.absolute_threshold = 1e-6;
    return c;
}

// read(write(c)) = c, field by field, for a configuration that differs from the defaults
// everywhere.
TEST(ConfigRoundTrip, WritingThenReadingIsTheIdentity) {
    const nn::Config c = config_with_no_default();
    for (const bool with_comments : {false, true}) {
        const nn::Config r = parse_config(write_config(c, with_comments), "c.yaml");
        EXPECT_EQ(r.kind, c.kind);
        EXPECT_EQ(r.stacked.attention, c.stacked.attention);
        EXPECT_EQ(r.stacked.joint, c.stacked.joint);
        EXPECT_EQ(r.stacked.tied, c.stacked.tied);
        EXPECT_EQ(r.stacked.latent_activation, c.stacked.latent_activation);
        EXPECT_EQ(r.stacked.decoder_fc_activation, c.stacked.decoder_fc_activation);
        EXPECT_EQ(r.stacked.mask_power, c.stacked.mask_power);
        EXPECT_EQ(r.stacked.mask_epsilon, c.stacked.mask_epsilon);
        ASSERT_EQ(r.stacked.levels.size(), c.stacked.levels.size());
        for (std::size_t i = 0; i < c.stacked.levels.size(); ++i) {
            EXPECT_EQ(r.stacked.levels[i].components, c.stacked.levels[i].components);
            EXPECT_EQ(r.stacked.levels[i].sparsity_range, c.stacked.levels[i].sparsity_range);
            EXPECT_EQ(r.stacked.levels[i].max_support, c.stacked.levels[i].max_support);
            EXPECT_EQ(r.stacked.levels[i].sparsity_ramp.has_value(),
                      c.stacked.levels[i].sparsity_ramp.has_value());
        }
        EXPECT_EQ(r.stacked.levels[0].sparsity_ramp->from, c.stacked.levels[0].sparsity_ramp->from);
        EXPECT_EQ(r.stacked.levels[0].sparsity_ramp->to, c.stacked.levels[0].sparsity_ramp->to);
        EXPECT_EQ(r.loss.reconstruction, c.loss.reconstruction);
        EXPECT_EQ(r.loss.sparsity, c.loss.sparsity);
        EXPECT_EQ(r.loss.range, c.loss.range);
        EXPECT_EQ(r.loss.range_limit, c.loss.range_limit);
        EXPECT_EQ(r.data.features, c.data.features);
        EXPECT_EQ(r.data.split.train, c.data.split.train);
        EXPECT_EQ(r.data.split.step, c.data.split.step);
        EXPECT_EQ(r.data.split.count, c.data.split.count);
        EXPECT_EQ(r.data.split.seed, c.data.split.seed);
        EXPECT_EQ(r.data.split.path, c.data.split.path);
        EXPECT_EQ(r.data.center, c.data.center);
        EXPECT_EQ(r.data.scale, c.data.scale);
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
        EXPECT_EQ(r.train.plateau_epochs, c.train.plateau_epochs);
        EXPECT_EQ(r.train.plateau_gain, c.train.plateau_gain);
        EXPECT_EQ(r.train.checkpoint_every, c.train.checkpoint_every);
        EXPECT_EQ(r.filter.minimum_strength, c.filter.minimum_strength);
        EXPECT_EQ(r.filter.relative_threshold, c.filter.relative_threshold);
        EXPECT_EQ(r.filter.absolute_threshold, c.filter.absolute_threshold);
    }
}

// Guards the test above: a key that is added to the table has to be added to it, too.
TEST(ConfigRoundTrip, TheExampleDiffersFromTheDefaultsInEveryKeyButTheKind) {
    nn::Config c = config_with_no_default();
    c.stacked.levels.resize(2);
    c.stacked.levels[1] = {3, 1, 0.5, nn::SparsityRamp{0, 1}};
    std::istringstream example(all_of(c)), defaults(all_of(nn::Config{}));
    std::string line, default_line;
    while (std::getline(example, line) && std::getline(defaults, default_line)) {
        const bool is_section = line.ends_with(':');
        if (is_section || line == "  kind: stacked-attention") continue;
        EXPECT_NE(line, default_line);
    }
    EXPECT_FALSE(std::getline(defaults, default_line));
}

TEST(ConfigRoundTrip, InitReadsBackAsTheDefaults) {
    nn::Config defaults;
    defaults.data.features = "features.safetensors";
    const std::string text = write_config(default_config("stacked-attention"), true);
    EXPECT_EQ(all_of(parse_config(text, "c.yaml")), all_of(defaults));
}

// read(write(c)) = c for the other kinds, seen through what is written: no field has its default.
TEST(ConfigRoundTrip, WhatOtherKindsWriteReadsBack) {
    nn::Config vae = default_config("spectral-vae");
    vae.spectral = {7,
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
    vae.spectral_loss = {2, 3, 4, 5, 6, 7};
    nn::Config one = default_config("autoencoder");
    one.stacked.levels = {{9, 0.125, 0.5, nn::SparsityRamp{0.25, 0.75}}};
    one.stacked.tied = nn::Tied::none;
    one.stacked.latent_activation = nn::Activation::tanh;
    one.stacked.decoder_fc_activation = nn::Activation::tanh;
    one.loss = {2, 3, 4, 6};
    for (const nn::Config& c : {vae, one}) {
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
    const std::string text = write_config(default_config("stacked-attention"), true);
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
