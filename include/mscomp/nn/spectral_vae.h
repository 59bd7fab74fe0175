// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/lane_batch.h"
#include "mscomp/nn/parameter_set.h"
#include "mscomp/nn/spectral_config.h"
#include "mscomp/nn/spectral_ops.h"
#include "mscomp/nn/tape.h"
#include "mscomp/nn/vertex_order.h"

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
/// noise, X^ = tanh(sum_h T_h (C^T z) theta'_h). All arrays that come in or go out are in the
/// vertex order of the user; inside, vertices are in reverse Cuthill-McKee order.
template <class T>
class SpectralVae {
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
    const VertexOrder& order() const { return order_; }
    const ScaledLaplacian<T>& laplacian() const { return laplacian_; }
    ParameterSet<T>& parameters() { return parameters_; }
    const ParameterSet<T>& parameters() const { return parameters_; }
    const Parameters& indices() const { return indices_; }
    Tape<T>& tape() { return tape_; }
    ComponentCenters<T>& component_centers() { return centers_; }
    int vertex_count() const { return order_.vertex_count(); }
    int batch_capacity() const { return options_.batch; }

    /// Makes shapes `which` of `features` (N,V,9) the batch, without noise; scaled features, at
    /// least one shape and at most the capacity.
    template <class Source>
    void load_batch(std::span<const Source> features, std::span<const int> which);
    /// The same from features that lie elsewhere and are not scaled yet.
    void load_batch(const ScaledFeatures& features, std::span<const int> which);
    /// A batch that was gathered in order() for lane_count(batch_capacity()) lanes.
    void load_batch(const LaneBatch& batch);

    /// Standard normal noise for the batch, a function of seed, step, the number of the shape and
    /// the component: the same in whatever batch a shape comes.
    void draw_noise(std::uint64_t seed, std::int64_t step);
    /// Noise (n,K) of the caller.
    void set_noise(std::span<const T> noise);

    /// Runs the batch; returns the total loss.
    T forward();
    /// Gradients of the last forward pass, added to those of the parameters.
    void backward();
    /// Brings the ranges d back into [0, 1]; to be called after each step.
    void clamp_ranges();

    SpectralTerms terms();
    /// mu, sigma and the sampled z of the batch after forward, (n,K) each.
    std::vector<T> codes();
    std::vector<T> deviations();
    std::vector<T> sampled_codes();
    /// What the decoder makes of the sampled z, (n,V,9).
    std::vector<T> reconstruction();
    /// Gradient of the batch after backward, (n,V,9); needs Options::input_gradient.
    std::vector<T> input_gradient();
    /// What the decoder makes of a code (K) of the caller, (V,9).
    std::vector<T> decode(std::span<const T> code);

    /// Centre vertex of every component, (K); empty before the first pass.
    std::vector<int> centers() const;
    void set_centers(const std::vector<int>& user);

    /// A parameter-sized array of entry `index` in the vertex order of the user, and back.
    std::vector<T> to_user_order(int index, std::span<const T> inner) const;
    void from_user_order(int index, std::span<const T> user, std::span<T> inner) const;

  private:
    void add_parameters();
    void record(const SpectralLossConfig& loss);
    void start_batch(std::span<const int> which);
    std::vector<T> batch_codes(std::span<const T> codes) const;
    std::vector<T> batch_rows(std::span<const T> rows, int lanes, int count) const;
    std::vector<T> decode_lanes(std::span<const T> codes, int lanes, int count);

    SpectralConfig config_;
    Options options_;
    VertexOrder order_;
    ScaledLaplacian<T> laplacian_;
    ReorderedDistances inner_distances_;
    LaneMask<T> lane_mask_;
    std::vector<int> shapes_;  // of the lanes
    ParameterSet<T> parameters_;
    Parameters indices_;
    Tape<T> tape_;
    ComponentCenters<T> centers_;
    BatchTerms<T> batch_terms_;
    Var x_, noise_, moments_, sampled_, total_;
    Var reconstruction_, kl_, sparsity_, range_, sparsity_range_;
};

/// The proximal step of Omega in Adam's metric, to be taken after adam_step; see
/// proximal_step(StackedModel&) for the equation. Leaves exact zeros.
template <class T>
void proximal_step(SpectralVae<T>& model, double sparsity_weight, double rate, std::int64_t step);

}  // namespace mscomp::nn
