// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/config.h"
#include "nn/active_vertices.h"
#include "nn/model.h"
#include "nn/ops.h"
#include "nn/parameter_set.h"
#include "nn/tape.h"

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
/// number * components + component.
template <class T>
class StackedModel final : public Model<T> {
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
        /// (1), the error of the sum of all levels up to this one; not valid where each autoencoder
        /// has an error of its own instead.
        Var sum_error;
    };

    StackedModel(const StackedConfig& config, const LossConfig& loss, const OneRings& rings,
                 DistanceRows& distances, const Options& options);

    const StackedConfig& config() const { return config_; }
    const std::vector<Level>& levels() const { return levels_; }
    T forward_and_backward() override;
    std::vector<std::string> term_names() const override;
    std::vector<double> term_values() override;
    double touched() const override { return touched(static_cast<int>(levels_.size()) - 1); }

    void start(const TrainConfig& train, const ScaledFeatures& features,
               std::span<const int> shapes) override;
    void update(const TrainConfig& train, double rate, std::int64_t step) override;

    std::vector<LevelSize> level_sizes() const override;
    bool refines_components() const override { return config_.attention; }
    int component_weights(int level) const override { return levels_[at(level)].weights; }
    /// Terms of one autoencoder after forward.
    AutoencoderTerms terms(int level, int autoencoder);
    std::vector<T> codes(int level) override;
    /// Input of one autoencoder after forward, (V,9,lanes) in inner vertex order.
    void input_rows(int level, int autoencoder, std::span<T> rows);
    std::vector<T> reconstruction(int levels) override;
    std::unique_ptr<CodeDecoder> decoder() const override;

    std::vector<int> centers(int level) const override;
    void set_centers(int level, std::vector<int> user) override;

    bool has_supports() const;
    /// Which vertices act in the autoencoders of a level, (A,V); others have zero weights.
    std::vector<std::uint8_t> acting(int level) const;
    void set_acting(int level, std::span<const std::uint8_t> user);
    std::vector<std::uint8_t> acting_vertices() const override;
    bool restore_acting_vertices(std::span<const std::uint8_t> acting) override;
    /// The last level acts where its weights are not zero and nowhere else.
    void act_where_weights_are();
    /// After backward and before the update of step `step`: evaluates the gradient of the component
    /// weights of the last level at every vertex and decides anew who acts. With g the length of a
    /// component's gradient at a vertex, l = sparsity_weight Lambda / K and h = 2/n sum of the
    /// squared codes (about the curvature of the error in a weight), moving the weight from zero
    /// can gain about max(g - l, 0)^2 / (2 h). Vertices where the sum over the components exceeds
    /// kWorthwhile / V of the error (of the sum: shared among the autoencoders) are admitted, with
    /// second moments as if the gradient had always been this; vertices whose weights are all
    /// exactly zero and would gain less than a quarter of that are dropped. At a fixed point the
    /// vertices left out could lower the error by about a part kWorthwhile in all. Overwrites the
    /// gradient of the level's source.
    ///
    /// This, set_acting and act_where_weights_are end the pass: nothing of it can be read any more.
    SupportChange adapt_supports(double sparsity_weight, std::int64_t step);
    static constexpr double kWorthwhile = 1e-4;
    /// Share of vertices that the autoencoders of a level touch, on average.
    double touched(int level) const;

  private:
    void add_levels(const LossConfig& loss, Var x);
    Var add_fused(Level& level, const LossConfig& loss, Var source, Var mask, bool keeps_residual);
    void add_small_ops(Level& level, Var x);
    bool has_sum_error(const Level& level) const;
    /// Where they are: without a slope they stay there.
    void hold_biases();
    void set_inner_acting(int level, std::span<const std::uint8_t> acts);
    std::vector<std::uint8_t> inner_acting(int level) const;
    /// Of the last level, where weights are not zero; in inner numbering too.
    std::vector<std::uint8_t> acting_by_weights() const;
    std::vector<double> curvatures(int autoencoder);
    double worthwhile(int autoencoder);

    using Model<T>::order_;
    using Model<T>::inner_distances_;
    using Model<T>::lane_mask_;
    using Model<T>::parameters_;
    using Model<T>::tape_;
    using Model<T>::x_;
    using Model<T>::total_;

    StackedConfig config_;
    double sparsity_weight_;
    LossTarget target_;
    Options options_;
    RingTable<T> rings_;
    std::vector<std::unique_ptr<SparsityRows>> sparsity_;   // per level
    std::vector<std::unique_ptr<LevelSupports>> supports_;  // likewise
    std::vector<Autoencoder<T>*> fused_;                    // on the tape; none with small ops
    std::vector<Level> levels_;
};

/// The proximal step of group sparsity in Adam's metric, to be taken after adam_step:
/// C_k,i <- C_k,i max(0, 1 - rate w Lambda_ik / (K sqrt(v) |C_k,i|)), w = sparsity weight, v =
/// Adam's bias-corrected second moment averaged over the nine channels (method §7). Leaves exact
/// zeros.
template <class T>
void proximal_step(StackedModel<T>& model, double sparsity_weight, double rate, std::int64_t step);

}  // namespace mscomp::nn
