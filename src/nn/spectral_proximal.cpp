// SPDX-License-Identifier: MIT
#include <cmath>

#include "mscomp/base/parallel.h"
#include "mscomp/nn/spectral_vae.h"

namespace mscomp::nn {

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
    const double threshold = rate * sparsity_weight / model.config().components;
    const T bound = static_cast<T>(threshold * threshold * channels * correction);
    const std::int64_t vertices = model.vertex_count();
    parallel_for(model.config().components, [&](std::int64_t k) {
        const std::span<const double> distances = centers.distances(k);
        const std::span<const T> lengths = centers.lengths(k);
        const auto range = static_cast<double>(ranges[static_cast<std::size_t>(k)]);
        for (std::int64_t v = 0; v < vertices; ++v) {
            const auto n = static_cast<std::size_t>(v);
            if (!(distances[n] > range) || lengths[n] == 0) continue;
            const std::size_t first =
                static_cast<std::size_t>(k * vertices + v) * static_cast<std::size_t>(channels);
            T square = 0;  // channels * correction * v * |C|^2, to be compared with the threshold's
            for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
                square += moment2[first + c];
            }
            square *= lengths[n] * lengths[n];
            // No slope was ever seen here (0): nothing holds the entry against the penalty.
            const T keep = square > bound ? 1 - std::sqrt(bound / square) : T{0};
            for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
                weights[first + c] *= keep;
            }
        }
    });
}

template void proximal_step(SpectralVae<float>&, double, double, std::int64_t);
template void proximal_step(SpectralVae<double>&, double, double, std::int64_t);

}  // namespace mscomp::nn
