// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "mscomp/model/config.h"
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
    /// Convolutions have biases ([A]). Without them the reference, which is zero, comes back
    /// exactly.
    bool bias = false;
    double mask_power = 8.0;  // attention masks ~ a^p, > 0; 1 = the paper
    double mask_epsilon = 1e-12;
    std::vector<LevelConfig> levels{{10, 0.4, {}, {}}, {5, 0.3, {}, {}}};
};

/// What the autoencoders of every level but the first are to describe (method §9).
enum class LossTarget {
    sum,    // together with all levels before, the shape: one error of the sum of all outputs
    share,  // each its masked share of what the level before left ([A])
};

/// Weights of the loss of every autoencoder, all >= 0.
struct LossConfig {
    double reconstruction = 1.0;
    double sparsity = 1000.0;
    double range = 1.0;
    /// Codes above it are penalised, >= 0. Empty: 5 up to 10,000 vertices, and on finer meshes
    /// what comes to the same (nn/resolution.h); a number: that on every mesh, in the papers 5.
    std::optional<double> range_limit;
    LossTarget target = LossTarget::sum;
};

/// What the configuration of a kind of stacked autoencoders holds for itself.
struct StackedSettings {
    StackedConfig model;
    LossConfig loss;
};

}  // namespace mscomp::nn
