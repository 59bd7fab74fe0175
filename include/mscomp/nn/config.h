// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mscomp/nn/spectral_config.h"
#include "mscomp/nn/tied.h"

namespace mscomp::nn {

/// Weights of the group sparsity by normalised geodesic distance: a clipped ramp from 0 at `from`
/// to 1 at `to` (the AAAI-18 predecessor), instead of the step at the sparsity range.
struct SparsityRamp {
    double from = 0.2;
    double to = 0.4;
};

struct LevelConfig {
    int components = 10;          // K of each autoencoder of the level, >= 1
    double sparsity_range = 0.4;  // d, normalised geodesic distance, [0, 1]
    /// Full penalty begins where at most this part of the vertices is nearer to the centre, (0, 1]:
    /// where many are near, the range shrinks. Empty: the range; 1: the paper.
    std::optional<double> max_support;
    std::optional<SparsityRamp> sparsity_ramp;
};

enum class Activation { none, tanh };

/// The stacked attention autoencoders of [A] with the readings of method §3, and with one level the
/// AAAI-18 autoencoder; defaults are the recommended ones of the former.
struct StackedConfig {
    bool attention = true;  // false: one child per parent, which sees the whole residual
    bool joint = true;      // false: gradients stop at masks and residual
    Tied tied = Tied::transpose;
    Activation latent_activation = Activation::none;
    Activation decoder_fc_activation = Activation::none;
    double mask_power = 8.0;  // attention masks ~ a^p, > 0; 1 = the paper
    double mask_epsilon = 1e-12;
    std::vector<LevelConfig> levels{{10, 0.4, {}, {}}, {5, 0.2, {}, {}}};
};

/// Weights of the loss of every autoencoder, all >= 0.
struct LossConfig {
    double reconstruction = 1.0;
    double sparsity = 1000.0;
    double range = 1.0;
    double range_limit = 5.0;
};

enum class SplitKind { all, every, random, file };

struct SplitConfig {
    SplitKind train = SplitKind::all;
    int step = 10;           // every: shapes 0, step, 2 step, ... train
    int count = 0;           // random: how many train
    std::uint64_t seed = 0;  // random
    std::string path;        // file: 0-based indices, one per line
};

enum class Scaling { reference, minmax };
enum class Scale { shared, separate };

struct DataConfig {
    std::string features;  // feature file; relative paths are relative to the config file
    SplitConfig split;
    Scaling center = Scaling::reference;
    Scale scale = Scale::shared;
};

enum class Start { deflation, random };
enum class SparsityStep { proximal, subgradient };

struct TrainConfig {
    int epochs = 500;
    int batch = 256;
    double learning_rate = 3e-3;       // the papers: 1e-3
    double learning_rate_decay = 0.9;  // factor per decay_steps, staircase
    int decay_steps = 4000;
    double learning_rate_floor = 1e-5;
    std::uint64_t seed = 0;
    Start start = Start::deflation;
    SparsityStep sparsity_step = SparsityStep::proximal;
    /// Steps of the last level leave out vertices where nothing acts (the same optimum, faster);
    /// needs the proximal step.
    bool supports = true;
    /// Fewer training shapes than this are joined by mixed ones (MixedFeatures), others every eight
    /// epochs; 0: never. Lanes come in sixteens, so that up to 48 cost what 36 do.
    int fill_up_to = 48;
    /// Training ends when the mean error of so many epochs is less than `plateau_gain` of it below
    /// that of as many before; 0: never before the last epoch.
    int plateau_epochs = 100;
    double plateau_gain = 0.005;
    int checkpoint_every = 100;  // epochs; the last one is always saved
};

/// The redundancy filter ([A] §4.3), in unscaled features.
struct FilterConfig {
    double minimum_strength = 0.01;    // epsilon_2
    double relative_threshold = 0.01;  // epsilon_1 as a fraction of the component's peak
    double absolute_threshold =
        0.0;  // epsilon_1 itself; > 0 replaces the relative one (paper: 1e-6)
};

/// What is trained and how. Which model and which loss count is decided by the kind.
struct Config {
    std::string kind = "stacked-attention";  // one of model_kinds()
    StackedConfig stacked;                   // stacked-attention, autoencoder
    LossConfig loss;
    SpectralConfig spectral;  // spectral-vae
    SpectralLossConfig spectral_loss;
    DataConfig data;
    TrainConfig train;
    FilterConfig filter;
};

}  // namespace mscomp::nn
