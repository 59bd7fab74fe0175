// SPDX-License-Identifier: MIT
#include "nn/optimizer.h"

#include <algorithm>
#include <cmath>

#include "kernels/kernels.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;

}  // namespace

double second_moment_correction(std::int64_t step) {
    return 1 - std::pow(kBeta2, static_cast<double>(step));
}

double learning_rate_at(const TrainConfig& config, std::int64_t step) {
    const double stairs = std::floor(static_cast<double>(step - 1) / config.decay_steps);
    return std::max(config.learning_rate * std::pow(config.learning_rate_decay, stairs),
                    std::min(config.learning_rate, config.learning_rate_floor));
}

template <class T>
int first_non_finite(const ParameterSet<T>& parameters, std::span<const T> all) {
    // 0 x stays 0 for every number and becomes NaN for all that is none.
    std::vector<T> zeros(at(parameters.live_piece_count()));
    parallel_for(parameters.live_piece_count(), [&](std::int64_t piece) {
        T zero = 0;
        for (const auto& range : parameters.live_piece(static_cast<int>(piece))) {
            zero += kernels<T>().zero_sum(all.data() + range.first, range.last - range.first);
        }
        zeros[at(piece)] = zero;
    });
    if (std::ranges::all_of(zeros, [](T zero) { return zero == 0; })) return -1;
    for (int i = 0; i < parameters.count(); ++i) {
        const auto& entry = parameters.entry(i);
        const auto own = all.subspan(at(entry.offset), at(entry.count));
        if (!std::ranges::all_of(own, [](T x) { return std::isfinite(x); })) return i;
    }
    return -1;
}

template <class T>
void adam_step(ParameterSet<T>& parameters, double rate, std::int64_t step) {
    const auto correction1 = static_cast<T>(1 - std::pow(kBeta1, static_cast<double>(step)));
    const auto correction2 = static_cast<T>(second_moment_correction(step));
    parallel_for(parameters.live_piece_count(), [&](std::int64_t piece) {
        const double scale = parameters.rate_scale_of(static_cast<int>(piece));
        for (const auto& range : parameters.live_piece(static_cast<int>(piece))) {
            kernels<T>().adam(parameters.all_values().data() + range.first,
                              parameters.all_moments1().data() + range.first,
                              parameters.all_moments2().data() + range.first,
                              parameters.all_grads().data() + range.first, range.last - range.first,
                              static_cast<T>(rate * scale), static_cast<T>(kBeta1),
                              static_cast<T>(kBeta2), correction1, correction2,
                              static_cast<T>(kEpsilon));
        }
    });
}

template int first_non_finite(const ParameterSet<float>&, std::span<const float>);
template int first_non_finite(const ParameterSet<double>&, std::span<const double>);
template void adam_step(ParameterSet<float>&, double, std::int64_t);
template void adam_step(ParameterSet<double>&, double, std::int64_t);

}  // namespace mscomp::nn
