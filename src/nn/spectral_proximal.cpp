// SPDX-License-Identifier: MIT
#include <cmath>
#include <vector>

#include "kernels/spectral_kernels.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "nn/spectral_vae.h"

namespace mscomp::nn {

namespace {

template <class T>
double square(T value) {
    return static_cast<double>(value) * static_cast<double>(value);
}

template <class T>
double square_length(const T* values, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) sum += square(values[i]);
    return sum;
}

}  // namespace

template <class T>
void add_range_slopes(SpectralVae<T>& model) {
    constexpr double kShell = 0.1;
    ParameterSet<T>& parameters = model.parameters();
    const auto& indices = model.indices();
    const std::span<const T> weights = parameters.value(indices.weights);
    const std::span<const T> grads = parameters.grad(indices.weights);
    const std::span<const T> ranges = parameters.value(indices.ranges);
    const std::span<T> slopes = parameters.grad(indices.ranges);
    const std::vector<T> codes = model.codes(), deviations = model.deviations();
    const std::int64_t components = model.config().components, vertices = model.vertex_count();
    const int channels = model.config().conv_channels;
    const double shapes = static_cast<double>(codes.size()) / static_cast<double>(components);
    parallel_for(components, [&](std::int64_t k) {
        const std::span<const double> distance = model.component_centers().distances(k);
        const auto range = static_cast<double>(ranges[at(k)]);
        double means = 0, variances = 0;
        for (std::size_t m = at(k); m < codes.size(); m += at(components)) {
            means += square(codes[m]);
            variances += square(deviations[m]);
        }
        // What almost no shape uses has the curvature of its noise, not next to none.
        const double curvature = 2 * model.loss().reconstruction / shapes * (means + variances);
        const double width = kShell * range;
        if (!(means > 0) || !(curvature > 0) || !(width > 0)) return;
        double gain = 0;
        for (std::int64_t v = 0; v < vertices; ++v) {
            const double beyond = distance[at(v)] - range;
            if (std::abs(beyond) >= width) continue;
            const std::size_t place = at((k * vertices + v) * channels);
            gain += beyond > 0 ? square_length(grads.data() + place, channels) / (2 * curvature)
                               : square_length(weights.data() + place, channels) * curvature / 2;
        }
        slopes[at(k)] -= static_cast<T>(gain / (2 * width));
    });
}

template <class T>
void proximal_step(SpectralVae<T>& model, double sparsity_weight, double rate, std::int64_t step) {
    if (!(sparsity_weight > 0)) return;
    ParameterSet<T>& parameters = model.parameters();
    const std::span<T> weights = parameters.value(model.indices().weights);
    const std::span<const T> moment2 = parameters.moment2(model.indices().weights);
    const std::span<const T> ranges = parameters.value(model.indices().ranges);
    const int channels = model.config().conv_channels;
    ComponentCenters<T>& centers = model.component_centers();
    centers.focus(weights, channels, ranges);
    const double correction = 1 - std::pow(0.999, static_cast<double>(step));
    const double scaled_rate = rate * parameters.entry(model.indices().weights).rate_scale;
    const double threshold = scaled_rate * sparsity_weight / model.config().components;
    // 1 - threshold / (sqrt(v) |C|), v the mean over channels of moment2 / correction. Where no
    // slope was ever seen (0) nothing holds the entry against the penalty.
    const T bound = static_cast<T>(threshold * threshold * channels * correction);
    const std::int64_t vertices = model.vertex_count();
    parallel_for(model.config().components, [&](std::int64_t k) {
        const auto range = static_cast<double>(ranges[at(k)]);
        const std::int64_t first = k * vertices * channels;
        spectral_kernels<T>().shrink(moment2.data() + first, centers.distances(k).data(),
                                     centers.lengths(k).data(), range, bound, channels,
                                     static_cast<int>(vertices), weights.data() + first);
    });
}

template void add_range_slopes(SpectralVae<float>&);
template void add_range_slopes(SpectralVae<double>&);
template void proximal_step(SpectralVae<float>&, double, double, std::int64_t);
template void proximal_step(SpectralVae<double>&, double, double, std::int64_t);

}  // namespace mscomp::nn
