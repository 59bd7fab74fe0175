// SPDX-License-Identifier: MIT
#include "nn/spectral_vae.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/dim.h"
#include "nn/optimizer.h"
#include "nn/resolution.h"
#include "sum_decoder.h"

namespace mscomp::nn {
namespace {

/// Streams of random numbers for the noise of the steps, away from those of start and batches.
constexpr std::uint64_t kNoiseStreams = std::uint64_t{1} << 62;

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

double spread_offset(const SpectralConfig& config, const SpectralLossConfig& loss) {
    if (config.spread_offset) return *config.spread_offset;
    const double variance = loss.kl > 0 ? loss.kl / (2 * loss.reconstruction + loss.kl) : 1e-4;
    return config.spread == Spread::log_variance ? std::log(variance) : std::sqrt(variance);
}

template <class T>
SpectralVae<T>::SpectralVae(const SpectralConfig& config, const SpectralLossConfig& loss,
                            const OneRings& rings, std::span<const double> edge_weights,
                            DistanceRows& distances, const Options& options)
    : Model<T>(rings, distances, options.batch),
      config_(config),
      loss_(loss),
      options_(options),
      laplacian_(inner_laplacian<T>(rings, order_, edge_weights, config.lambda_max)),
      centers_(inner_distances_,
               options.sparsity_gradient ? CenterRule::follow : CenterRule::settle),
      batch_terms_(laplacian_, config.filter_order, lane_count(options.batch)) {
    options_.fused =
        options.fused && config.conv_channels == kFeatureDim && !options.input_gradient;
    add_parameters();
    record();
}

template <class T>
void SpectralVae<T>::add_parameters() {
    const std::int64_t order = config_.filter_order, channels = config_.conv_channels;
    indices_.theta = parameters_.add("theta", {order, kDim, channels});
    indices_.decoder_theta = config_.own_decoder()
                                 ? parameters_.add("decoder_theta", {order, channels, kDim})
                                 : indices_.theta;
    const Extents weights{1, config_.components, this->vertex_count(), channels};
    indices_.weights = this->add_component_weights("component_weights", weights);
    // Codes are sums over V and may grow with sqrt(V); logarithms of their spread must not.
    constexpr double kSpreadExponent = 2;
    indices_.spread_weights =
        this->add_component_weights("spread_weights", weights, kSpreadExponent);
    indices_.ranges = parameters_.add("sparsity_ranges", {config_.components});
    if (!options_.sparsity_gradient) {
        // Slopes of ranges are those of the best weights, which have to keep up.
        constexpr double kRangeRate = 0.1;
        parameters_.set_rate_scale(indices_.ranges, kRangeRate);
    }
    std::ranges::fill(parameters_.value(indices_.ranges), static_cast<T>(config_.initial_range));
}

/// theta' on a tape whose parameters are numbered as those of the model.
template <class T>
Var SpectralVae<T>::decoder_filters(Tape<T>& tape, ParameterSet<T>& parameters) const {
    const Var theta = tape.parameter(parameters, indices_.decoder_theta);
    return config_.tied == Tied::transpose ? transpose_filters(tape, theta) : theta;
}

template <class T>
void SpectralVae<T>::record() {
    const auto parameter = [&](int index) { return tape_.parameter(parameters_, index); };
    const std::int64_t lanes = lane_count(options_.batch);
    const Var theta = parameter(indices_.theta), weights = parameter(indices_.weights);
    const Var spread_weights = parameter(indices_.spread_weights);
    this->record_input(options_.input_gradient);
    noise_ = tape_.input("noise", {1, config_.components, lanes});
    moments_ =
        options_.fused
            ? spectral_encoder(tape_, batch_terms_, theta, weights, spread_weights)
            : project_moments(tape_, cheb_conv(tape_, laplacian_, x_, theta, Activation::tanh),
                              weights, spread_weights);
    const double offset = spread_offset(config_, loss_);
    if (offset != 0) moments_ = offset_spread(tape_, moments_, offset);
    sampled_ = sample_codes(tape_, moments_, noise_, config_.spread);
    if (!options_.losses) {
        total_ = weighted_sum(tape_, {}, {});
        return;
    }
    const Var back = decoder_filters(tape_, parameters_);
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
    const CodeLimit codes = code_limit(loss_.range_limit, loss_.range, this->vertex_count());
    range_ = range_penalty(tape_, sampled_, codes.limit, lane_mask_);
    sparsity_range_ = range_term(tape_, ranges, config_.range_term);
    total_ = weighted_sum(
        tape_, {reconstruction_, kl_, sparsity_, range_, sparsity_range_},
        {loss_.reconstruction, loss_.kl, loss_.sparsity, codes.weight, loss_.sparsity_range});
}

template <class T>
void SpectralVae<T>::batch_loaded(std::span<const int> shapes) {
    shapes_.assign(shapes.begin(), shapes.end());
    std::ranges::fill(tape_.value(noise_), T{0});
    if (options_.fused) batch_terms_.prepare(tape_.value(x_), lane_mask_.active);
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
void SpectralVae<T>::clamp_ranges() {
    for (T& d : parameters_.value(indices_.ranges)) d = std::clamp(d, T{0}, T{1});
}

template <class T>
SpectralTerms SpectralVae<T>::terms() {
    const auto read = [&](Var term) { return static_cast<double>(tape_.value(term)[0]); };
    return {read(reconstruction_), read(kl_), read(sparsity_), read(range_), read(sparsity_range_)};
}

template <class T>
std::vector<std::string> SpectralVae<T>::term_names() const {
    return {"reconstruction", "kl", "sparsity", "range", "sparsity_range"};
}

template <class T>
std::vector<double> SpectralVae<T>::term_values() {
    const SpectralTerms all = terms();
    return {all.reconstruction, all.kl, all.sparsity, all.range, all.sparsity_range};
}

template <class T>
void SpectralVae<T>::update(const TrainConfig& train, double rate, std::int64_t step) {
    const bool is_proximal = train.sparsity_step == SparsityStep::proximal;
    if (!config_.learned_range) {
        std::ranges::fill(parameters_.grad(indices_.ranges), T{0});
    } else if (is_proximal) {
        add_range_slopes(*this);
    }
    adam_step(parameters_, rate, step);
    if (is_proximal) {
        proximal_step(*this, loss_.sparsity, rate, step);
    }
    clamp_ranges();
}

template <class T>
std::vector<T> SpectralVae<T>::codes(int /*level*/) {
    return this->batch_codes(tape_.value(moments_).first(tape_.value(noise_).size()));
}

template <class T>
std::vector<T> SpectralVae<T>::deviations() {
    std::vector<T> result =
        this->batch_codes(tape_.value(moments_).subspan(tape_.value(noise_).size()));
    if (config_.spread == Spread::log_variance) {
        for (T& s : result) s = std::exp(s / 2);
    }
    return result;
}

template <class T>
std::vector<T> SpectralVae<T>::sampled_codes() {
    return this->batch_codes(tape_.value(sampled_));
}

/// Rows (V,9,lanes) that codes (K,lanes) decode to, before or after the last activation.
template <class T>
std::vector<T> SpectralVae<T>::decode_lanes(std::span<const T> codes, int lanes,
                                            Activation activation) const {
    ParameterSet<T> own;  // the same entries, since the tape may write to them
    for (int index = 0; index < parameters_.count(); ++index) {
        own.add(parameters_.entry(index).name, parameters_.entry(index).extents);
    }
    for (const int index : {indices_.weights, indices_.decoder_theta}) {
        std::ranges::copy(parameters_.value(index), own.value(index).begin());
    }
    Tape<T> tape;
    const Var z = tape.input("codes", {1, config_.components, lanes});
    std::ranges::copy(codes, tape.value(z).begin());
    const Var output =
        cheb_conv(tape, laplacian_, expand_codes(tape, z, tape.parameter(own, indices_.weights)),
                  decoder_filters(tape, own), activation);
    tape.forward();
    return {tape.value(output).begin(), tape.value(output).end()};
}

template <class T>
std::vector<T> SpectralVae<T>::reconstruction(int /*levels*/) {
    return this->batch_rows(decode_lanes(tape_.value(sampled_), this->lanes(), Activation::tanh));
}

template <class T>
std::unique_ptr<CodeDecoder> SpectralVae<T>::decoder() const {
    const int lanes = lane_count(1);
    SumDecoder::Part part;
    for (int first = 0; first < config_.components; first += lanes) {
        const int count = std::min(lanes, config_.components - first);
        std::vector<T> unit(at(std::int64_t{config_.components} * lanes), T{0});
        for (int k = 0; k < count; ++k) unit[at((first + k) * lanes + k)] = T{1};
        const std::vector<T> rows = decode_lanes(unit, lanes, Activation::none);
        for (DecoderColumn& column :
             sparse_columns(std::span<const T>(rows), lanes, count, order_)) {
            part.columns.push_back(std::move(column));
        }
    }
    std::vector<SumDecoder::Part> parts;
    parts.push_back(std::move(part));
    return std::make_unique<SumDecoder>(this->vertex_count(), std::move(parts));
}

template <class T>
std::vector<int> SpectralVae<T>::centers(int /*level*/) const {
    std::vector<int> user;
    for (const int inner : centers_.centers()) {
        user.push_back(inner < 0 ? inner : order_.to_user[at(inner)]);
    }
    return user;
}

template <class T>
void SpectralVae<T>::set_centers(int /*level*/, std::vector<int> user) {
    std::vector<int> inner;
    for (const int v : user) inner.push_back(v < 0 ? v : order_.to_internal[at(v)]);
    centers_.set_centers(std::move(inner));
}

template class SpectralVae<float>;
template class SpectralVae<double>;

}  // namespace mscomp::nn
