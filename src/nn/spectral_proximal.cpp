// SPDX-License-Identifier: MIT
#include <cmath>

#include "kernels/spectral_kernels.h"
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
    // 1 - threshold / (sqrt(v) |C|), v the mean over channels of moment2 / correction. Where no
    // slope was ever seen (0) nothing holds the entry against the penalty.
    const T bound = static_cast<T>(threshold * threshold * channels * correction);
    const std::int64_t vertices = model.vertex_count();
    parallel_for(model.config().components, [&](std::int64_t k) {
        const auto range = static_cast<double>(ranges[static_cast<std::size_t>(k)]);
        const std::int64_t first = k * vertices * channels;
        spectral_kernels<T>().shrink(moment2.data() + first, centers.distances(k).data(),
                                     centers.lengths(k).data(), range, bound, channels,
                                     static_cast<int>(vertices), weights.data() + first);
    });
}

template void proximal_step(SpectralVae<float>&, double, double, std::int64_t);
template void proximal_step(SpectralVae<double>&, double, double, std::int64_t);

}  // namespace mscomp::nn
