// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/spectral_config.h"
#include "nn/model.h"
#include "nn/spectral_ops.h"

namespace mscomp::nn {

/// Terms of the loss of the VAE, before their weights.
struct SpectralTerms {
    double reconstruction = 0;
    double kl = 0;
    double sparsity = 0;        // Omega
    double range = 0;           // Pi
    double sparsity_range = 0;  // Phi
};

/// The spectral VAE of [B]: f = tanh(sum_h T_h X theta_h), mu = C f, s = C_std f, z = mu + sigma
/// noise, X^ = tanh(sum_h T_h (C^T z) theta'_h). One level; a batch comes without noise, so that
/// codes decode as they are.
template <class T>
class SpectralVae final : public Model<T> {
  public:
    struct Options {
        int batch = 256;  // most shapes of a forward pass
        /// The papers' subgradient with centres that follow; false: the proximal step handles
        /// sparsity, around centres that settle.
        bool sparsity_gradient = false;
        bool input_gradient = false;  // for checks; needs small ops
        bool losses = true;           // false: encode and decode only, no distances are asked for
        /// Encoder and decoder as one op each; false: of small ops, as is every model with
        /// conv_channels other than 9.
        bool fused = true;
    };
    /// Where the parameters are: theta (H,9,d'), decoder_theta (H,d',9), component_weights and
    /// spread_weights (1,K,V,d'), sparsity_ranges (K).
    struct Parameters {
        int theta = -1, decoder_theta = -1, weights = -1, spread_weights = -1, ranges = -1;
    };

    /// `edge_weights`: one positive number for each entry of rings.neighbors (say cotangents), or
    /// none for the 0/1 adjacency. Ranges start as configured, all else at zero.
    SpectralVae(const SpectralConfig& config, const SpectralLossConfig& loss, const OneRings& rings,
                std::span<const double> edge_weights, DistanceRows& distances,
                const Options& options);

    const SpectralConfig& config() const { return config_; }
    const ScaledLaplacian<T>& laplacian() const { return laplacian_; }
    const Parameters& indices() const { return indices_; }
    const SpectralLossConfig& loss() const { return loss_; }
    ComponentCenters<T>& component_centers() { return centers_; }

    /// Standard normal noise for the batch, a function of seed, step, the number of the shape and
    /// the component: the same in whatever batch a shape comes.
    void draw_noise(std::uint64_t seed, std::int64_t step);
    /// Noise (n,K) of the caller.
    void set_noise(std::span<const T> noise);

    /// Brings the ranges d back into [0, 1]; to be called after each step.
    void clamp_ranges();

    SpectralTerms terms();
    std::vector<std::string> term_names() const override;
    std::vector<double> term_values() override;

    void start(const TrainConfig& train, const ScaledFeatures& features,
               std::span<const int> shapes) override;
    void prepare_step(std::uint64_t seed, std::int64_t step) override { draw_noise(seed, step); }
    void update(const TrainConfig& train, double rate, std::int64_t step) override;

    std::vector<LevelSize> level_sizes() const override { return {{1, config_.components}}; }
    int component_weights(int /*level*/) const override { return indices_.weights; }
    std::vector<int> centers(int level = 0) const override;
    void set_centers(int level, std::vector<int> user) override;
    /// The batch, (V,9,lanes) in inner vertex order.
    std::span<const T> input_rows() { return tape_.value(x_); }
    /// mu, sigma and the sampled z of the batch after forward, (n,K) each.
    std::vector<T> codes(int level = 0) override;
    std::vector<T> deviations();
    std::vector<T> sampled_codes();
    /// What the decoder makes of the sampled z, (n,V,9).
    std::vector<T> reconstruction(int levels = 1) override;
    std::unique_ptr<CodeDecoder> decoder() const override;

  private:
    void add_parameters();
    void record();
    Var decoder_filters(Tape<T>& tape, ParameterSet<T>& parameters) const;
    void batch_loaded(std::span<const int> shapes) override;
    std::vector<T> decode_lanes(std::span<const T> codes, int lanes, Activation activation) const;

    using Model<T>::order_;
    using Model<T>::inner_distances_;
    using Model<T>::lane_mask_;
    using Model<T>::parameters_;
    using Model<T>::tape_;
    using Model<T>::x_;
    using Model<T>::total_;

    SpectralConfig config_;
    SpectralLossConfig loss_;
    Options options_;
    ScaledLaplacian<T> laplacian_;
    std::vector<int> shapes_;  // of the lanes
    Parameters indices_;
    ComponentCenters<T> centers_;
    BatchTerms<T> batch_terms_;
    Var noise_, moments_, sampled_;
    Var reconstruction_, kl_, sparsity_, range_, sparsity_range_;
};

/// The slope of the best loss in every range, added to the gradients of the ranges after backward.
/// Beside exact zeros the straight-through slope is blind: Omega is zero whatever the range, and
/// Phi alone would shrink it to nothing. By the envelope theorem the slope is what the error would
/// rise by if the shell of width delta inside the range lost its weights, and fall by if the one
/// outside got some, per unit of range: -(1/(2 delta)) (sum_in h |C_k,i|^2/2 + sum_out |g_k,i|^2/(2
/// h)), g the gradient of the weights, h = 2 w/n sum_m (mu_mk^2 + sigma_mk^2) (about its own
/// slope), w the weight of the reconstruction, delta a tenth of the range. Components that no shape
/// uses (mu = 0) get none.
template <class T>
void add_range_slopes(SpectralVae<T>& model);

/// The proximal step of Omega in Adam's metric, to be taken after adam_step; see
/// proximal_step(StackedModel&) for the equation. Leaves exact zeros.
template <class T>
void proximal_step(SpectralVae<T>& model, double sparsity_weight, double rate, std::int64_t step);

}  // namespace mscomp::nn
