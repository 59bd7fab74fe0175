// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/active_vertices.h"
#include "mscomp/nn/config.h"
#include "mscomp/nn/lane_batch.h"
#include "mscomp/nn/ops.h"
#include "mscomp/nn/parameter_set.h"
#include "mscomp/nn/tape.h"
#include "mscomp/nn/vertex_order.h"

namespace mscomp::nn {

template <class T>
class Autoencoder;

/// Loss terms of one autoencoder, before their weights.
struct AutoencoderTerms {
    double reconstruction = 0;
    double sparsity = 0;
    double range = 0;
};

/// The stacked attention autoencoders of [A]: level 0 has one autoencoder, every further level one
/// per component of the level before (one per autoencoder without attention). Child number = parent
/// number * components + component. All arrays that come in or go out are in the vertex order of
/// the user; inside, vertices are in reverse Cuthill-McKee order.
template <class T>
class StackedModel {
  public:
    struct Options {
        int batch = 256;  // most shapes of a forward pass
        /// The papers' subgradient with centres that follow; false: the proximal step handles
        /// sparsity, around centres that settle.
        bool sparsity_gradient = false;
        bool input_gradient = false;  // for checks
        bool losses = true;           // false: encode and decode only, no distances are asked for
        /// A level as one op (fused.h); false: of small ops, as is every model whose decoder has
        /// an activation between its two layers.
        bool fused = true;
        /// The last level touches only vertices where components act (adapt_supports); needs fused
        /// levels and no sparsity gradient, which would never leave zeros.
        bool supports = false;
    };
    /// What adapt_supports changed, summed over autoencoders.
    struct SupportChange {
        std::int64_t admitted = 0, dropped = 0;
    };
    /// What one level consists of. Parameters are named level<l>.<what>.
    struct Level {
        int autoencoders = 1;
        int components = 0;
        SparsityRows* sparsity = nullptr;             // owned by the model
        LevelSupports* supports = nullptr;            // likewise; what fused levels touch
        int w_own = -1, w_ring = -1, bias = -1;       // convolution of the encoder
        int decoder_w_own = -1, decoder_w_ring = -1;  // equal to these unless tied: none
        int decoder_bias = -1;
        int weights = -1;         // C (A,K,V,9)
        Var source, source_mask;  // the input of an autoencoder is mask times source; with small
        Var x, output;            // ops it is x itself, and output what is made of it
        Var code, mask, reconstruction, group_sparsity, range_penalty;
    };

    StackedModel(const ModelConfig& config, const LossConfig& loss, const OneRings& rings,
                 DistanceRows& distances, const Options& options);

    const ModelConfig& config() const { return config_; }
    const VertexOrder& order() const { return order_; }
    ParameterSet<T>& parameters() { return parameters_; }
    const ParameterSet<T>& parameters() const { return parameters_; }
    Tape<T>& tape() { return tape_; }
    const std::vector<Level>& levels() const { return levels_; }
    /// Distances in inner numbering.
    DistanceRows& inner_distances() { return inner_distances_; }
    int vertex_count() const { return order_.vertex_count(); }
    int batch_capacity() const { return options_.batch; }

    /// Makes shapes `which` of `features` (N,V,9) the batch; scaled features, at least one shape
    /// and at most the capacity.
    template <class Source>
    void load_batch(std::span<const Source> features, std::span<const int> which);
    /// The same from features that lie elsewhere and are not scaled yet.
    void load_batch(const ScaledFeatures& features, std::span<const int> which);
    /// A batch that was gathered in order() for lane_count(batch_capacity()) lanes.
    void load_batch(const LaneBatch& batch);

    /// Runs the batch; returns the total loss.
    T forward();
    /// Gradients of the last forward pass, added to those of the parameters.
    void backward();
    /// Both, faster, with the same result; nothing can be read in between, and afterwards there is
    /// no reconstruction.
    T forward_and_backward();

    /// Terms of one autoencoder after forward.
    AutoencoderTerms terms(int level, int autoencoder);
    /// Codes of a level after forward, (n, A*K).
    std::vector<T> codes(int level);
    /// Input of one autoencoder after forward, (V,9,lanes) in inner vertex order.
    void input_rows(int level, int autoencoder, std::span<T> rows);
    /// Sum of the outputs of the first `levels` levels after forward and before backward, (n,V,9).
    std::vector<T> reconstruction(int levels);
    /// Gradient of the batch after backward, (n,V,9); needs Options::input_gradient.
    std::vector<T> input_gradient();
    /// Output of one autoencoder for a code (K) of the caller, (V,9).
    std::vector<T> decode(int level, int autoencoder, std::span<const T> code);

    /// Centre vertex of every component of a level, (A*K); empty before the first pass.
    std::vector<int> centers(int level) const;
    void set_centers(int level, std::vector<int> user);

    bool has_supports() const;
    /// Which vertices act in the autoencoders of a level, (A,V); others have zero weights.
    std::vector<std::uint8_t> acting(int level) const;
    void set_acting(int level, std::span<const std::uint8_t> user);
    /// The last level acts where its weights are not zero and nowhere else.
    void act_where_weights_are();
    /// After backward and before the update of step `step`: evaluates the gradient of the component
    /// weights of the last level at every vertex and decides anew who acts. With g the length of a
    /// component's gradient at a vertex, l = sparsity_weight Lambda / K and h = 2/n sum of the
    /// squared codes (about the curvature of the error in a weight), moving the weight from zero
    /// can gain about max(g - l, 0)^2 / (2 h). Vertices where the sum over the components exceeds
    /// kWorthwhile / V of the error are admitted, with second moments as if the gradient had always
    /// been this; vertices whose weights are all exactly zero and would gain less than a quarter of
    /// that are dropped. At a fixed point the vertices left out could lower the error by about a
    /// part kWorthwhile in all. Overwrites the gradient of the level's source.
    ///
    /// This, set_acting and act_where_weights_are end the pass: nothing of it can be read any more.
    SupportChange adapt_supports(double sparsity_weight, std::int64_t step);
    static constexpr double kWorthwhile = 1e-4;
    /// Share of vertices that the autoencoders of a level touch, on average.
    double touched(int level) const;

    /// A parameter-sized array of entry `index` in the vertex order of the user, and back.
    std::vector<T> to_user_order(int index, std::span<const T> inner) const;
    void from_user_order(int index, std::span<const T> user, std::span<T> inner) const;

  private:
    void add_levels(const LossConfig& loss, Var x);
    Var add_fused(Level& level, const LossConfig& loss, Var source, Var mask, bool keeps_residual);
    void add_small_ops(Level& level, Var x);
    void set_inner_acting(int level, std::span<const std::uint8_t> acts);
    std::vector<std::uint8_t> inner_acting(int level) const;
    std::vector<double> curvatures(int autoencoder);
    std::vector<T> batch_rows(std::span<const T> rows) const;
    void set_active_lanes(std::size_t count);

    ModelConfig config_;
    Options options_;
    VertexOrder order_;
    RingTable<T> rings_;
    ReorderedDistances inner_distances_;
    LaneMask<T> lane_mask_;
    ParameterSet<T> parameters_;
    Tape<T> tape_;
    std::vector<std::unique_ptr<SparsityRows>> sparsity_;   // per level
    std::vector<std::unique_ptr<LevelSupports>> supports_;  // likewise
    std::vector<Autoencoder<T>*> fused_;                    // on the tape; none with small ops
    std::vector<Level> levels_;
    Var total_;
};

}  // namespace mscomp::nn
