// SPDX-License-Identifier: MIT
#include "mscomp/nn/stacked_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "ops/autoencoder.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kDim = kFeatureDim;

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

/// Component weights start with unit length, so that an entry is about 1/sqrt(V). Adam's steps are
/// of the size of the rate whatever the gradient: on fine meshes they have to shrink as well.
double component_rate_scale(std::int64_t vertices) {
    constexpr double kOrdinary = 10000;
    return std::min(1.0, std::sqrt(kOrdinary / static_cast<double>(vertices)));
}

}  // namespace

template <class T>
StackedModel<T>::StackedModel(const ModelConfig& config, const LossConfig& loss,
                              const OneRings& rings, DistanceRows& distances,
                              const Options& options)
    : config_(config),
      options_(options),
      order_(reverse_cuthill_mckee(rings)),
      rings_(reordered(rings, order_)),
      inner_distances_(distances, order_) {
    const std::int64_t vertices = order_.vertex_count();
    lane_mask_.weight.assign(at(lane_count(options.batch)), T{0});

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
        level.weights = add("component_weights", {level.components, vertices, kDim});
        parameters_.set_rate_scale(level.weights, component_rate_scale(vertices));
        levels_.push_back(level);
        if (config.attention) autoencoders *= level.components;
    }

    add_levels(loss, tape_.input("x", {1, vertices, kDim, lane_count(options.batch)},
                                 options.input_gradient));
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
            level.range_penalty = range_penalty(tape_, level.code, loss.range_limit, lane_mask_);
            terms.insert(terms.end(),
                         {level.reconstruction, level.group_sparsity, level.range_penalty});
            factors.insert(factors.end(), {loss.reconstruction, loss.sparsity, loss.range});
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
    inputs.error_weight = loss.reconstruction;
    auto op = std::make_unique<Autoencoder<T>>(tape_, rings_, inputs, lane_mask_, *level.supports);
    fused_.push_back(op.get());
    level.code = op->outputs().code;
    level.reconstruction = op->outputs().error;
    tape_.record(std::move(op));
    return fused_.back()->outputs().residual;
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
template <class Source>
void StackedModel<T>::load_batch(std::span<const Source> features, std::span<const int> which) {
    assert(!which.empty() && static_cast<int>(which.size()) <= options_.batch);
    const std::int64_t lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    const std::int64_t rows = vertex_count() * kDim;
    set_active_lanes(which.size());
    const std::span<T> x = tape_.value(levels_.front().x);
    parallel_for(vertex_count(), [&](std::int64_t v) {
        const std::int64_t user = order_.to_user[at(v)];
        for (std::int64_t c = 0; c < kDim; ++c) {
            T* row = x.data() + (v * kDim + c) * lanes;
            for (std::int64_t l = 0; l < lanes; ++l) {
                row[l] = l < lane_mask_.active
                             ? static_cast<T>(features[at(which[at(l)] * rows + user * kDim + c)])
                             : T{0};
            }
        }
    });
}

template <class T>
void StackedModel<T>::load_batch(const ScaledFeatures& features, std::span<const int> which) {
    assert(!which.empty() && static_cast<int>(which.size()) <= options_.batch);
    set_active_lanes(which.size());
    gather_lanes(features, which, order_, tape_.value(levels_.front().x), GatherThreads::all);
}

template <class T>
void StackedModel<T>::load_batch(const LaneBatch& batch) {
    set_active_lanes(batch.shapes.size());
    const std::span<T> x = tape_.value(levels_.front().x);
    assert(x.size() == batch.rows.size());
    const Chunks chunks{static_cast<std::int64_t>(x.size()), std::int64_t{1} << 18};
    parallel_for(chunks.count(), [&](std::int64_t i) {
        std::copy(batch.rows.begin() + chunks.begin(i), batch.rows.begin() + chunks.end(i),
                  x.begin() + chunks.begin(i));
    });
}

template <class T>
void StackedModel<T>::set_active_lanes(std::size_t count) {
    lane_mask_.active = static_cast<int>(count);
    for (std::size_t l = 0; l < lane_mask_.weight.size(); ++l) {
        lane_mask_.weight[l] = l < count ? T{1} : T{0};
    }
}

template <class T>
T StackedModel<T>::forward() {
    tape_.forward();
    return tape_.value(total_)[0];
}

template <class T>
void StackedModel<T>::backward() {
    tape_.backward(total_);
}

template <class T>
T StackedModel<T>::forward_and_backward() {
    for (Autoencoder<T>* op : fused_) op->expect_backward(true);
    const T total = forward();
    for (Autoencoder<T>* op : fused_) op->expect_backward(false);
    backward();
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
std::vector<T> StackedModel<T>::to_user_order(int index, std::span<const T> inner) const {
    std::vector<T> user(inner.begin(), inner.end());
    const Extents& extents = parameters_.entry(index).extents;
    if (extents.size() != 4) return user;
    const std::int64_t vertices = extents[2];
    for (std::int64_t row = 0; row < extents[0] * extents[1]; ++row) {
        for (std::int64_t v = 0; v < vertices; ++v) {
            std::copy_n(inner.begin() + (row * vertices + v) * kDim, kDim,
                        user.begin() + (row * vertices + order_.to_user[at(v)]) * kDim);
        }
    }
    return user;
}

template <class T>
void StackedModel<T>::from_user_order(int index, std::span<const T> user,
                                      std::span<T> inner) const {
    const Extents& extents = parameters_.entry(index).extents;
    if (extents.size() != 4) {
        std::copy(user.begin(), user.end(), inner.begin());
        return;
    }
    const std::int64_t vertices = extents[2];
    for (std::int64_t row = 0; row < extents[0] * extents[1]; ++row) {
        for (std::int64_t v = 0; v < vertices; ++v) {
            std::copy_n(user.begin() + (row * vertices + order_.to_user[at(v)]) * kDim, kDim,
                        inner.begin() + (row * vertices + v) * kDim);
        }
    }
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
template void StackedModel<float>::load_batch(std::span<const float>, std::span<const int>);
template void StackedModel<double>::load_batch(std::span<const float>, std::span<const int>);
template void StackedModel<double>::load_batch(std::span<const double>, std::span<const int>);

}  // namespace mscomp::nn
