// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "mscomp/nn/tied.h"

namespace mscomp::nn {

/// Largest eigenvalue of the normalised Laplacian: 2 (its bound, the authors' code) or computed.
enum class LambdaMax { two, exact };
/// Edge weights of the graph whose Laplacian is used.
enum class Adjacency { binary, cotangent };
/// What C_std f is: log sigma^2, or sigma itself ([B] eq. 4 as printed).
enum class Spread { log_variance, linear };
/// Where the straight-through slope dDelta/dd = -1 holds: outside the range, or everywhere.
enum class StraightThrough { outside, identity };
/// Phi(d): sum of max(d_k, 0), or |d| ([B] eq. 8 as printed).
enum class RangeTerm { sum, l2 };

/// The spectral VAE of [B] with the readings of method §4; defaults are the recommended ones.
struct SpectralConfig {
    int components = 50;    // K, latent dimension, >= 1
    int filter_order = 3;   // H of the Chebyshev convolutions, 1 to 16
    int conv_channels = 9;  // d' of f, >= 1
    /// theta' of the decoder: that of the encoder transposed, the same ([B]), or its own.
    Tied tied = Tied::transpose;
    Adjacency adjacency = Adjacency::binary;
    LambdaMax lambda_max = LambdaMax::two;
    Spread spread = Spread::log_variance;
    /// Added to C_std f, so that there is little noise at the reference too, where f is zero.
    /// Empty: where noise along a direction of unit length costs as much as it gains in divergence;
    /// 0: [B].
    std::optional<double> spread_offset;
    double kl_epsilon = 1e-8;  // inside the logarithm of a linear sigma, >= 0
    StraightThrough straight_through = StraightThrough::outside;
    RangeTerm range_term = RangeTerm::sum;
    bool learned_range = true;    // false: d_k stays the initial range
    double initial_range = 0.15;  // d_k at the start, normalised geodesic distance, [0, 1]

    /// theta' is a parameter; filters that are the same need nine channels on both sides.
    bool own_decoder() const {
        return tied == Tied::none || (tied == Tied::same && conv_channels != 9);
    }
};

/// Weights of the terms of the loss, all >= 0, [B] eq. 13.
struct SpectralLossConfig {
    double reconstruction = 1.0;
    double kl = 0.001;                  // the paper: 0.01
    double sparsity = 1000.0;           // Omega
    double range = 1.0;                 // Pi
    double sparsity_range = 1.0;        // Phi
    std::optional<double> range_limit;  // theta of Pi, as in LossConfig
};

/// The offset that spread_offset stands for: the minimum of reconstruction e^s + kl (e^s - s - 1)/2
/// as log-variance or as sigma.
double spread_offset(const SpectralConfig& config, const SpectralLossConfig& loss);

/// What the configuration of the kind holds for itself.
struct SpectralSettings {
    SpectralConfig model;
    SpectralLossConfig loss;
};

}  // namespace mscomp::nn
