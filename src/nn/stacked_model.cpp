// SPDX-License-Identifier: MIT
#include "nn/stacked_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/dim.h"
#include "nn/optimizer.h"
#include "nn/resolution.h"
#include "nn/start.h"
#include "ops/autoencoder.h"

namespace mscomp::nn {
namespace {

/// Whether supports are decided anew in a step: often at first, when the most changes.
bool adapts_supports(std::int64_t step) {
    constexpr std::int64_t kInterval = 50;
    return step % kInterval == 0 || step == 1 || step == 6 || step == 15 || step == 30;
}

}  // namespace

template <class T>
StackedModel<T>::StackedModel(const StackedConfig& config, const LossConfig& loss,
                              const OneRings& rings, DistanceRows& distances,
                              const Options& options)
    : Model<T>(rings, distances, options.batch),
      config_(config),
      sparsity_weight_(loss.sparsity),
      target_(loss.target),
      options_(options),
      rings_(reordered(rings, order_)) {
    const std::int64_t vertices = order_.vertex_count();

    // All parameters first: recording on the tape borrows their memory.
    int autoencoders = 1;
    for (std::size_t l = 0; l < config.levels.size(); ++l) {
        Level level;
        level.autoencoders = autoencoders;
        level.components = config.levels[l].components;
        supports_.push_back(std::make_unique<LevelSupports>(rings_.rings, autoencoders));
        sparsity_.push_back(std::make_unique<SparsityRows>(
            inner_distances_, config.levels[l],
            options.sparsity_gradient ? CenterRule::follow : CenterRule::settle,
            supports_.back().get()));
        level.sparsity = sparsity_.back().get();
        level.supports = supports_.back().get();
        const auto add = [&](const char* what, Extents extents) {
            extents.insert(extents.begin(), autoencoders);
            return parameters_.add(fmt::format("level{}.{}", l, what), std::move(extents));
        };
        level.w_own = add("w_own", {kDim, kDim});
        level.w_ring = add("w_ring", {kDim, kDim});
        level.bias = add("bias", {kDim});
        const bool own_decoder = config.tied == Tied::none;
        level.decoder_w_own = own_decoder ? add("decoder_w_own", {kDim, kDim}) : level.w_own;
        level.decoder_w_ring = own_decoder ? add("decoder_w_ring", {kDim, kDim}) : level.w_ring;
        level.decoder_bias = add("decoder_bias", {kDim});
        level.weights =
            this->add_component_weights(fmt::format("level{}.component_weights", l),
                                        {autoencoders, level.components, vertices, kDim});
        levels_.push_back(level);
        if (config.attention) autoencoders *= level.components;
    }

    add_levels(loss, this->record_input(options.input_gradient));
}

template <class T>
void StackedModel<T>::add_levels(const LossConfig& loss, Var x) {
    const bool is_fused = options_.fused && config_.decoder_fc_activation == Activation::none;
    std::vector<Var> terms;
    std::vector<double> factors;
    Var source = x, mask;
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        Level& level = levels_[l];
        const bool is_last = l + 1 == levels_.size();
        const Var weights = tape_.parameter(parameters_, level.weights);
        Var residual;
        if (is_fused) {
            residual = add_fused(level, loss, source, mask, !is_last);
        } else {
            add_small_ops(level, x);
        }
        if (l == 0) level.x = x;
        if (options_.losses) {
            level.group_sparsity =
                group_sparsity(tape_, weights, *level.sparsity, options_.sparsity_gradient);
            const CodeLimit codes = code_limit(loss.range_limit, loss.range, this->vertex_count());
            level.range_penalty = range_penalty(tape_, level.code, codes.limit, lane_mask_);
            const bool has_sum = has_sum_error(level);
            if (has_sum && !is_fused) {
                std::vector<Var> outputs;
                for (std::size_t j = 0; j <= l; ++j) outputs.push_back(levels_[j].output);
                level.sum_error =
                    squared_error(tape_, levels_.front().x,
                                  sum_rows(tape_, std::move(outputs), config_.joint), lane_mask_);
            }
            terms.insert(terms.end(), {has_sum ? level.sum_error : level.reconstruction,
                                       level.group_sparsity, level.range_penalty});
            factors.insert(factors.end(), {loss.reconstruction, loss.sparsity, codes.weight});
        }
        if (is_last) break;
        if (config_.attention) {
            level.mask = attention_mask(tape_, weights, config_.mask_power, config_.mask_epsilon);
        }
        mask = level.mask;
        source = residual;
        if (!is_fused) x = masked_residual(tape_, x, level.output, mask, config_.joint);
    }
    total_ = weighted_sum(tape_, std::move(terms), std::move(factors));
}

template <class T>
Var StackedModel<T>::add_fused(Level& level, const LossConfig& loss, Var source, Var mask,
                               bool keeps_residual) {
    const auto parameter = [&](int which) { return tape_.parameter(parameters_, which); };
    level.source = source;
    level.source_mask = mask;
    AutoencoderInputs inputs;
    inputs.source = source;
    inputs.mask = mask;
    inputs.w_own = parameter(level.w_own);
    inputs.w_ring = parameter(level.w_ring);
    inputs.bias = parameter(level.bias);
    inputs.decoder_w_own = parameter(level.decoder_w_own);
    inputs.decoder_w_ring = parameter(level.decoder_w_ring);
    inputs.decoder_bias = parameter(level.decoder_bias);
    inputs.component_weights = parameter(level.weights);
    inputs.transposed_decoder = config_.tied == Tied::transpose;
    inputs.latent_activation = config_.latent_activation;
    inputs.joint = &level == &levels_.front() || config_.joint;
    inputs.keeps_residual = keeps_residual;
    inputs.keeps_sum_error = options_.losses && has_sum_error(level);
    inputs.error_weight = loss.reconstruction;
    auto op = std::make_unique<Autoencoder<T>>(tape_, rings_, inputs, lane_mask_, *level.supports);
    fused_.push_back(op.get());
    level.code = op->outputs().code;
    level.reconstruction = op->outputs().error;
    level.sum_error = op->outputs().sum_error;
    tape_.record(std::move(op));
    return fused_.back()->outputs().residual;
}

/// The first level has nothing before it, and one autoencoder: its error is that of the sum.
template <class T>
bool StackedModel<T>::has_sum_error(const Level& level) const {
    return target_ == LossTarget::sum && &level != &levels_.front();
}

template <class T>
void StackedModel<T>::add_small_ops(Level& level, Var x) {
    const auto parameter = [&](int which) { return tape_.parameter(parameters_, which); };
    const Var weights = parameter(level.weights);
    level.x = x;
    const Var f = mesh_conv(tape_, rings_, x, parameter(level.w_own), parameter(level.w_ring),
                            parameter(level.bias), false, Activation::tanh);
    level.code = project(tape_, f, weights);
    if (config_.latent_activation == Activation::tanh) level.code = tanh(tape_, level.code);
    Var decoded = expand(tape_, level.code, weights);
    if (config_.decoder_fc_activation == Activation::tanh) decoded = tanh(tape_, decoded);
    level.output = mesh_conv(tape_, rings_, decoded, parameter(level.decoder_w_own),
                             parameter(level.decoder_w_ring), parameter(level.decoder_bias),
                             config_.tied == Tied::transpose, Activation::tanh);
    if (options_.losses) level.reconstruction = squared_error(tape_, x, level.output, lane_mask_);
}

template <class T>
T StackedModel<T>::forward_and_backward() {
    for (Autoencoder<T>* op : fused_) op->expect_backward(true);
    const T total = this->forward();
    for (Autoencoder<T>* op : fused_) op->expect_backward(false);
    this->backward();
    return total;
}

template <class T>
AutoencoderTerms StackedModel<T>::terms(int level, int autoencoder) {
    const Level& l = levels_[at(level)];
    const auto read = [&](Var term) {
        return static_cast<double>(tape_.value(term)[at(autoencoder)]);
    };
    return {read(l.reconstruction), read(l.group_sparsity), read(l.range_penalty)};
}

template <class T>
std::vector<std::string> StackedModel<T>::term_names() const {
    std::vector<std::string> names;
    for (std::size_t l = 0; l < levels_.size(); ++l) {
        for (const char* what : {"reconstruction", "sparsity", "range"}) {
            names.push_back(fmt::format("level{}_{}", l, what));
        }
    }
    return names;
}

template <class T>
std::vector<double> StackedModel<T>::term_values() {
    std::vector<double> values;
    for (int l = 0; l < static_cast<int>(levels_.size()); ++l) {
        AutoencoderTerms sum;
        for (int a = 0; a < levels_[at(l)].autoencoders; ++a) {
            const AutoencoderTerms one = terms(l, a);
            sum.reconstruction += one.reconstruction;
            sum.sparsity += one.sparsity;
            sum.range += one.range;
        }
        if (const Var error = levels_[at(l)].sum_error; error.valid()) {
            sum.reconstruction = static_cast<double>(tape_.value(error)[0]);
        }
        values.insert(values.end(), {sum.reconstruction, sum.sparsity, sum.range});
    }
    return values;
}

template <class T>
void StackedModel<T>::start(const TrainConfig& train, const ScaledFeatures& features,
                            std::span<const int> shapes) {
    if (train.start == Start::deflation) {
        start_deflation(*this, features, shapes);
    } else {
        start_random(*this, train.seed);
    }
}

template <class T>
void StackedModel<T>::hold_biases() {
    for (const Level& level : levels_) {
        for (const int index : {level.bias, level.decoder_bias}) {
            std::ranges::fill(parameters_.grad(index), T{0});
        }
    }
}

template <class T>
void StackedModel<T>::update(const TrainConfig& train, double rate, std::int64_t step) {
    if (has_supports() && adapts_supports(step)) adapt_supports(sparsity_weight_, step);
    if (!config_.bias) hold_biases();
    adam_step(parameters_, rate, step);
    if (train.sparsity_step == SparsityStep::proximal) {
        proximal_step(*this, sparsity_weight_, rate, step);
    }
}

template <class T>
std::vector<LevelSize> StackedModel<T>::level_sizes() const {
    std::vector<LevelSize> sizes;
    for (const Level& level : levels_) sizes.push_back({level.autoencoders, level.components});
    return sizes;
}

template <class T>
std::vector<int> StackedModel<T>::centers(int level) const {
    std::vector<int> user = levels_[at(level)].sparsity->centers();
    for (int& v : user) v = v < 0 ? v : order_.to_user[at(v)];
    return user;
}

template <class T>
void StackedModel<T>::set_centers(int level, std::vector<int> user) {
    for (int& v : user) v = v < 0 ? v : order_.to_internal[at(v)];
    levels_[at(level)].sparsity->set_centers(std::move(user));
}

template class StackedModel<float>;
template class StackedModel<double>;

}  // namespace mscomp::nn
