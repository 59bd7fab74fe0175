// SPDX-License-Identifier: MIT
// What the fused halves of the spectral autoencoder share. Pieces of sixteen vertices go through
// all that is done at a vertex while they are in cache, so that of all that lies between two
// formulas only f, C^T z, one slope and inner Chebyshev terms are ever stored.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "spectral_pieces.h"

namespace mscomp::nn {

inline constexpr int kFilterSize = kFeatureDim * kFeatureDim;
inline constexpr int kFilterColumns = 16;  // of the sums of outer_9x9

/// Scratch of one task; kept by its thread, so that a step allocates nothing.
template <class T>
struct Scratch {
    AlignedVector<T> rows, second_rows, products;

    static Scratch& of_thread(const LatentSize& size) {
        thread_local Scratch scratch;
        const auto rows = at(kPiece * kFeatureDim * size.lanes);
        scratch.rows.resize(std::max(scratch.rows.size(), rows));
        scratch.second_rows.resize(std::max(scratch.second_rows.size(), rows));
        const auto products = at(kPiece * kFeatureDim * size.padded());
        scratch.products.resize(std::max(scratch.products.size(), products));
        return scratch;
    }
};

/// Gradient of filters (H,9,9), summed per chunk over 16 columns.
template <class T>
class FilterGradient {
  public:
    FilterGradient(std::int64_t chunks, int order) : chunks_(chunks), order_(order) {
        sums_.resize(at(chunks * order * kFilterSize * kFilterColumns));
    }
    void clear() { std::fill(sums_.begin(), sums_.end(), T{0}); }
    T* sums(std::int64_t chunk, int degree) {
        return sums_.data() + (chunk * order_ + degree) * kFilterSize * kFilterColumns;
    }
    /// theta_grad += factor * sums.
    void add_to(std::span<T> theta_grad, T factor) const {
        parallel_for(std::int64_t{order_} * kFilterSize, [&](std::int64_t i) {
            double sum = 0;
            for (std::int64_t chunk = 0; chunk < chunks_; ++chunk) {
                const T* columns =
                    sums_.data() + (chunk * order_ * kFilterSize + i) * kFilterColumns;
                for (int n = 0; n < kFilterColumns; ++n) sum += static_cast<double>(columns[n]);
            }
            theta_grad[at(i)] += factor * static_cast<T>(sum);
        });
    }

  private:
    std::int64_t chunks_;
    int order_;
    AlignedVector<T> sums_;
};

}  // namespace mscomp::nn
