// SPDX-License-Identifier: MIT
#include "mscomp/nn/spectral_vae.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kDim = kFeatureDim;
/// Streams of random numbers for the noise of the steps, away from those of start and batches.
constexpr std::uint64_t kNoiseStreams = std::uint64_t{1} << 62;

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

/// Weights of the user's rings in the order of the inner ones.
std::vector<double> reordered_weights(const OneRings& user, const OneRings& inner,
                                      const VertexOrder& order, std::span<const double> weights) {
    assert(weights.empty() || weights.size() == user.neighbors.size());
    std::vector<double> result;
    if (weights.empty()) return result;
    for (int v = 0; v < inner.vertex_count(); ++v) {
        const std::size_t from = at(order.to_user[at(v)]);
        const auto ring_begin = user.neighbors.begin() + user.offsets[from];
        const auto ring_end = user.neighbors.begin() + user.offsets[from + 1];
        for (int n = inner.offsets[at(v)]; n < inner.offsets[at(v) + 1]; ++n) {
            const int neighbor = order.to_user[at(inner.neighbors[at(n)])];
            const auto place = std::lower_bound(ring_begin, ring_end, neighbor);
            result.push_back(weights[at(place - user.neighbors.begin())]);
        }
    }
    return result;
}

template <class T>
ScaledLaplacian<T> inner_laplacian(const OneRings& rings, const VertexOrder& order,
                                   std::span<const double> edge_weights, LambdaMax lambda_max) {
    OneRings inner = reordered(rings, order);
    const std::vector<double> weights = reordered_weights(rings, inner, order, edge_weights);
    return {std::move(inner), weights, lambda_max};
}

}  // namespace

template <class T>
SpectralVae<T>::SpectralVae(const SpectralConfig& config, const SpectralLossConfig& loss,
                            const OneRings& rings, std::span<const double> edge_weights,
                            DistanceRows& distances, const Options& options)
    : config_(config),
      options_(options),
      order_(reverse_cuthill_mckee(rings)),
      laplacian_(inner_laplacian<T>(rings, order_, edge_weights, config.lambda_max)),
      inner_distances_(distances, order_),
      centers_(inner_distances_,
               options.sparsity_gradient ? CenterRule::follow : CenterRule::settle),
      batch_terms_(laplacian_, config.filter_order, lane_count(options.batch)) {
    options_.fused =
        options.fused && config.conv_channels == kFeatureDim && !options.input_gradient;
    lane_mask_.weight.assign(at(lane_count(options.batch)), T{0});
    add_parameters();
    record(loss);
}

template <class T>
void SpectralVae<T>::add_parameters() {
    const std::int64_t order = config_.filter_order, channels = config_.conv_channels;
    indices_.theta = parameters_.add("theta", {order, kDim, channels});
    indices_.decoder_theta = config_.own_decoder()
                                 ? parameters_.add("decoder_theta", {order, channels, kDim})
                                 : indices_.theta;
    const Extents weights{1, config_.components, vertex_count(), channels};
    indices_.weights = parameters_.add("component_weights", weights);
    indices_.spread_weights = parameters_.add("spread_weights", weights);
    indices_.ranges = parameters_.add("sparsity_ranges", {config_.components});
    std::ranges::fill(parameters_.value(indices_.ranges), static_cast<T>(config_.initial_range));
}

template <class T>
void SpectralVae<T>::record(const SpectralLossConfig& loss) {
    const auto parameter = [&](int index) { return tape_.parameter(parameters_, index); };
    const std::int64_t lanes = lane_count(options_.batch);
    const Var theta = parameter(indices_.theta), weights = parameter(indices_.weights);
    const Var spread_weights = parameter(indices_.spread_weights);
    x_ = tape_.input("x", {1, vertex_count(), kDim, lanes}, options_.input_gradient);
    noise_ = tape_.input("noise", {1, config_.components, lanes});
    moments_ =
        options_.fused
            ? spectral_encoder(tape_, batch_terms_, theta, weights, spread_weights)
            : project_moments(tape_, cheb_conv(tape_, laplacian_, x_, theta, Activation::tanh),
                              weights, spread_weights);
    sampled_ = sample_codes(tape_, moments_, noise_, config_.spread);
    if (!options_.losses) {
        total_ = weighted_sum(tape_, {}, {});
        return;
    }
    const Var back = config_.own_decoder() ? parameter(indices_.decoder_theta) : theta;
    if (options_.fused) {
        reconstruction_ =
            spectral_decoder(tape_, laplacian_, sampled_, weights, back, x_, lane_mask_);
    } else {
        const Var output = cheb_conv(tape_, laplacian_, expand_codes(tape_, sampled_, weights),
                                     back, Activation::tanh);
        reconstruction_ = squared_error(tape_, x_, output, lane_mask_);
    }
    const Var ranges = parameter(indices_.ranges);
    kl_ = kl_divergence(tape_, moments_, config_.spread, config_.kl_epsilon, lane_mask_);
    sparsity_ = learned_sparsity(tape_, weights, ranges, centers_, config_.straight_through,
                                 options_.sparsity_gradient);
    range_ = range_penalty(tape_, sampled_, loss.range_limit, lane_mask_);
    sparsity_range_ = range_term(tape_, ranges, config_.range_term);
    total_ = weighted_sum(
        tape_, {reconstruction_, kl_, sparsity_, range_, sparsity_range_},
        {loss.reconstruction, loss.kl, loss.sparsity, loss.range, loss.sparsity_range});
}

template <class T>
void SpectralVae<T>::start_batch(std::span<const int> which) {
    assert(!which.empty() && static_cast<int>(which.size()) <= options_.batch);
    shapes_.assign(which.begin(), which.end());
    lane_mask_.active = static_cast<int>(which.size());
    for (std::size_t l = 0; l < lane_mask_.weight.size(); ++l) {
        lane_mask_.weight[l] = l < which.size() ? T{1} : T{0};
    }
    std::ranges::fill(tape_.value(noise_), T{0});
    if (options_.fused) batch_terms_.prepare(tape_.value(x_), lane_mask_.active);
}

template <class T>
template <class Source>
void SpectralVae<T>::load_batch(std::span<const Source> features, std::span<const int> which) {
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    const std::int64_t rows = vertex_count() * kDim;
    const std::span<T> x = tape_.value(x_);
    parallel_for(vertex_count(), [&](std::int64_t v) {
        const std::int64_t user = order_.to_user[at(v)];
        for (std::int64_t c = 0; c < kDim; ++c) {
            T* row = x.data() + (v * kDim + c) * lanes;
            for (std::int64_t l = 0; l < lanes; ++l) {
                row[l] = l < static_cast<std::int64_t>(which.size())
                             ? static_cast<T>(features[at(which[at(l)] * rows + user * kDim + c)])
                             : T{0};
            }
        }
    });
    start_batch(which);
}

template <class T>
void SpectralVae<T>::load_batch(const ScaledFeatures& features, std::span<const int> which) {
    gather_lanes(features, which, order_, tape_.value(x_), GatherThreads::all);
    start_batch(which);
}

template <class T>
void SpectralVae<T>::load_batch(const LaneBatch& batch) {
    const std::span<T> x = tape_.value(x_);
    assert(x.size() == batch.rows.size());
    const Chunks chunks{static_cast<std::int64_t>(x.size()), std::int64_t{1} << 18};
    parallel_for(chunks.count(), [&](std::int64_t i) {
        std::copy(batch.rows.begin() + chunks.begin(i), batch.rows.begin() + chunks.end(i),
                  x.begin() + chunks.begin(i));
    });
    start_batch(batch.shapes);
}

template <class T>
void SpectralVae<T>::draw_noise(std::uint64_t seed, std::int64_t step) {
    const CounterRandom random(seed, kNoiseStreams + static_cast<std::uint64_t>(step));
    const std::span<T> noise = tape_.value(noise_);
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    for (std::int64_t k = 0; k < config_.components; ++k) {
        for (std::size_t m = 0; m < shapes_.size(); ++m) {
            const std::int64_t index = std::int64_t{shapes_[m]} * config_.components + k;
            noise[at(k * lanes) + m] =
                static_cast<T>(random.normal(static_cast<std::uint64_t>(index)));
        }
    }
}

template <class T>
void SpectralVae<T>::set_noise(std::span<const T> noise) {
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    for (std::int64_t m = 0; m < lane_mask_.active; ++m) {
        for (std::int64_t k = 0; k < config_.components; ++k) {
            tape_.value(noise_)[at(k * lanes + m)] = noise[at(m * config_.components + k)];
        }
    }
}

template <class T>
T SpectralVae<T>::forward() {
    tape_.forward();
    return tape_.value(total_)[0];
}

template <class T>
void SpectralVae<T>::backward() {
    tape_.backward(total_);
}

template <class T>
void SpectralVae<T>::clamp_ranges() {
    for (T& d : parameters_.value(indices_.ranges)) d = std::clamp(d, T{0}, T{1});
}

template <class T>
SpectralTerms SpectralVae<T>::terms() {
    const auto read = [&](Var term) { return static_cast<double>(tape_.value(term)[0]); };
    return {read(reconstruction_), read(kl_), read(sparsity_), read(range_), read(sparsity_range_)};
}

template <class T>
std::vector<T> SpectralVae<T>::batch_codes(std::span<const T> codes) const {
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    std::vector<T> result;
    for (int m = 0; m < lane_mask_.active; ++m) {
        for (std::int64_t k = 0; k < config_.components; ++k) {
            result.push_back(codes[at(k * lanes + m)]);
        }
    }
    return result;
}

template <class T>
std::vector<T> SpectralVae<T>::codes() {
    return batch_codes(tape_.value(moments_));
}

template <class T>
std::vector<T> SpectralVae<T>::deviations() {
    std::vector<T> result = batch_codes(tape_.value(moments_).subspan(tape_.value(noise_).size()));
    if (config_.spread == Spread::log_variance) {
        for (T& s : result) s = std::exp(s / 2);
    }
    return result;
}

template <class T>
std::vector<T> SpectralVae<T>::sampled_codes() {
    return batch_codes(tape_.value(sampled_));
}

template <class T>
std::vector<T> SpectralVae<T>::batch_rows(std::span<const T> rows, int lanes, int count) const {
    const std::int64_t size = vertex_count() * kDim;
    std::vector<T> result(at(size * count));
    for (std::int64_t v = 0; v < vertex_count(); ++v) {
        for (std::int64_t c = 0; c < kDim; ++c) {
            for (std::int64_t m = 0; m < count; ++m) {
                result[at(m * size + order_.to_user[at(v)] * kDim + c)] =
                    rows[at((v * kDim + c) * lanes + m)];
            }
        }
    }
    return result;
}

template <class T>
std::vector<T> SpectralVae<T>::decode_lanes(std::span<const T> codes, int lanes, int count) {
    Tape<T> tape;
    const Var z = tape.input("codes", {1, config_.components, lanes});
    std::ranges::copy(codes, tape.value(z).begin());
    const Var weights = tape.parameter(parameters_, indices_.weights);
    const Var theta = tape.parameter(parameters_, indices_.decoder_theta);
    const Var output =
        cheb_conv(tape, laplacian_, expand_codes(tape, z, weights), theta, Activation::tanh);
    tape.forward();
    return batch_rows(tape.value(output), lanes, count);
}

template <class T>
std::vector<T> SpectralVae<T>::reconstruction() {
    return decode_lanes(tape_.value(sampled_), static_cast<int>(lane_mask_.weight.size()),
                        lane_mask_.active);
}

template <class T>
std::vector<T> SpectralVae<T>::input_gradient() {
    return batch_rows(tape_.grad(x_), static_cast<int>(lane_mask_.weight.size()),
                      lane_mask_.active);
}

template <class T>
std::vector<T> SpectralVae<T>::decode(std::span<const T> code) {
    const int lanes = lane_count(1);
    std::vector<T> codes(at(std::int64_t{config_.components} * lanes), T{0});
    for (std::int64_t k = 0; k < config_.components; ++k) codes[at(k * lanes)] = code[at(k)];
    return decode_lanes(codes, lanes, 1);
}

template <class T>
std::vector<int> SpectralVae<T>::centers() const {
    std::vector<int> user;
    for (const int inner : centers_.centers()) {
        user.push_back(inner < 0 ? inner : order_.to_user[at(inner)]);
    }
    return user;
}

template <class T>
void SpectralVae<T>::set_centers(const std::vector<int>& user) {
    std::vector<int> inner;
    for (const int v : user) inner.push_back(v < 0 ? v : order_.to_internal[at(v)]);
    centers_.set_centers(std::move(inner));
}

template <class T>
std::vector<T> SpectralVae<T>::to_user_order(int index, std::span<const T> inner) const {
    std::vector<T> user(inner.begin(), inner.end());
    const Extents& extents = parameters_.entry(index).extents;
    if (extents.size() != 4) return user;
    const std::int64_t channels = extents[3], vertices = extents[2];
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(inner.size()); ++i) {
        const std::int64_t row = i / channels, v = row % vertices;
        user[at((row - v + order_.to_user[at(v)]) * channels + i % channels)] = inner[at(i)];
    }
    return user;
}

template <class T>
void SpectralVae<T>::from_user_order(int index, std::span<const T> user, std::span<T> inner) const {
    std::ranges::copy(user, inner.begin());
    const Extents& extents = parameters_.entry(index).extents;
    if (extents.size() != 4) return;
    const std::int64_t channels = extents[3], vertices = extents[2];
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(inner.size()); ++i) {
        const std::int64_t row = i / channels, v = row % vertices;
        inner[at(i)] = user[at((row - v + order_.to_user[at(v)]) * channels + i % channels)];
    }
}

template class SpectralVae<float>;
template class SpectralVae<double>;
template void SpectralVae<float>::load_batch(std::span<const float>, std::span<const int>);
template void SpectralVae<double>::load_batch(std::span<const float>, std::span<const int>);
template void SpectralVae<double>::load_batch(std::span<const double>, std::span<const int>);

}  // namespace mscomp::nn
