// SPDX-License-Identifier: MIT
#include <cmath>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "nn/optimizer.h"
#include "nn/sparsity_rows.h"
#include "nn/stacked_model.h"

namespace mscomp::nn {
namespace {

/// Shrinks the nine entries of one vertex, |c| = length; `threshold` = rate w Lambda / K.
template <class T>
void shrink(T* c, double length, const T* moment2, double correction, double threshold) {
    double v = 0;
    for (int i = 0; i < kFeatureDim; ++i) v += static_cast<double>(moment2[i]);
    const double root = std::sqrt(v / (kFeatureDim * correction));
    // No slope was ever seen here (root = 0): nothing holds the entry against the penalty.
    const double scaled = root * length;
    const T keep = scaled > threshold ? static_cast<T>(1 - threshold / scaled) : T{0};
    for (int i = 0; i < kFeatureDim; ++i) c[i] *= keep;
}

}  // namespace

template <class T>
void proximal_step(StackedModel<T>& model, double sparsity_weight, double rate, std::int64_t step) {
    if (!(sparsity_weight > 0)) return;
    const double correction = second_moment_correction(step);
    const int vertices = model.vertex_count();
    for (const auto& level : model.levels()) {
        const std::span<T> weights = model.parameters().value(level.weights);
        const double scaled_rate = rate * model.parameters().entry(level.weights).rate_scale;
        const std::span<const T> moment2 = model.parameters().moment2(level.weights);
        const std::vector<SparsityRow>& around = level.sparsity->focus(std::span<const T>(weights));
        parallel_for(level.sparsity->row_count(), [&](std::int64_t row) {
            const std::span<const int> acting = level.sparsity->acting(row);
            const std::span<const double> length = level.sparsity->lengths(row);
            for (std::size_t n = 0; n < acting.size(); ++n) {
                const double lambda = around[at(row)].weight(acting[n]);
                if (!(lambda > 0) || length[n] == 0) continue;
                const std::int64_t place = (row * vertices + acting[n]) * kFeatureDim;
                shrink(weights.data() + place, length[n], moment2.data() + place, correction,
                       scaled_rate * sparsity_weight * lambda / level.components);
            }
        });
    }
}

template void proximal_step(StackedModel<float>&, double, double, std::int64_t);
template void proximal_step(StackedModel<double>&, double, double, std::int64_t);

}  // namespace mscomp::nn
