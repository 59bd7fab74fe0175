// SPDX-License-Identifier: MIT
// What the spectral VAE begins with.
#include <algorithm>
#include <cmath>

#include "learning/deflation.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/dim.h"
#include "nn/spectral_vae.h"
#include "nn/start_shapes.h"

namespace mscomp::nn {
namespace {

/// Only the first filter, T_0 = X: f = tanh(X), as far as there are channels.
template <class T>
void set_identity(std::span<T> theta, std::int64_t rows, std::int64_t columns) {
    std::ranges::fill(theta, T{0});
    for (std::int64_t c = 0; c < std::min(rows, columns); ++c) theta[at(c * columns + c)] = T{1};
}

}  // namespace

template <class T>
void start_random(SpectralVae<T>& model, std::uint64_t seed) {
    constexpr double kDeviation = 0.02;
    ParameterSet<T>& parameters = model.parameters();
    model.set_centers(0, {});
    for (int index = 0; index < parameters.count(); ++index) {
        if (index == model.indices().ranges) continue;
        const CounterRandom random(seed, static_cast<std::uint64_t>(index) + 1);
        std::vector<T> drawn(parameters.value(index).size());
        for (std::size_t i = 0; i < drawn.size(); ++i) {
            drawn[i] = static_cast<T>(kDeviation * random.normal(i));
        }
        model.from_user_order(index, drawn, parameters.value(index));
    }
    std::ranges::fill(parameters.value(model.indices().ranges),
                      static_cast<T>(model.config().initial_range));
}

template <class T>
void start_deflation(SpectralVae<T>& model, const ScaledFeatures& features,
                     std::span<const int> shapes) {
    const SpectralConfig& config = model.config();
    const auto& indices = model.indices();
    ParameterSet<T>& parameters = model.parameters();
    parameters.reset_values();
    const std::int64_t channels = config.conv_channels;
    set_identity(parameters.value(indices.theta), kDim, channels);
    if (config.own_decoder()) {
        set_identity(parameters.value(indices.decoder_theta), channels, kDim);
    }
    std::ranges::fill(parameters.value(indices.ranges), static_cast<T>(config.initial_range));

    const StartShapes start(features, shapes, model.batch_capacity());
    const std::int64_t lanes = lane_count(model.batch_capacity());
    const std::int64_t vertices = model.vertex_count(), size = vertices * channels;
    DeflationResidual residual(vertices, start.count());
    for (std::size_t first = 0; first < start.shapes.size(); first += start.batch) {
        const auto pass = start.pass(first);
        const auto count = static_cast<std::int64_t>(pass.size());
        model.load_batch(start.features, pass);
        const std::span<const T> rows = model.input_rows();
        residual.fill(rows.data(), lanes, static_cast<std::int64_t>(first), count, squashed,
                      channels);
    }
    residual.drop_silent_vertices();
    const auto free_places = [&](int center, std::span<const int> places_of) {
        const std::span<const double> distance = model.inner_distances().row(center);
        std::vector<int> places;
        for (std::size_t n = 0; n < places_of.size(); ++n) {
            if (distance[at(places_of[n])] <= config.initial_range) {
                places.push_back(static_cast<int>(n));
            }
        }
        return places;
    };
    const auto found = deflate(residual, config.components, model.inner_distances(), free_places,
                               spread_vertices(model.inner_distances(), kCandidates));
    std::vector<int> centers;
    for (std::int64_t k = 0; k < config.components; ++k) {
        centers.push_back(model.order().to_user[at(found[at(k)].center)]);
        write_direction(residual, found[at(k)].direction, channels,
                        parameters.value(indices.weights).subspan(at(k * size), at(size)));
    }
    model.set_centers(0, std::move(centers));
}

template <class T>
void SpectralVae<T>::start(const TrainConfig& train, const ScaledFeatures& features,
                           std::span<const int> shapes) {
    if (train.start == Start::deflation) {
        start_deflation(*this, features, shapes);
    } else {
        start_random(*this, train.seed);
    }
}

template void start_random(SpectralVae<float>&, std::uint64_t);
template void start_random(SpectralVae<double>&, std::uint64_t);
template void start_deflation(SpectralVae<float>&, const ScaledFeatures&, std::span<const int>);
template void start_deflation(SpectralVae<double>&, const ScaledFeatures&, std::span<const int>);
template void SpectralVae<float>::start(const TrainConfig&, const ScaledFeatures&,
                                        std::span<const int>);
template void SpectralVae<double>::start(const TrainConfig&, const ScaledFeatures&,
                                         std::span<const int>);

}  // namespace mscomp::nn
