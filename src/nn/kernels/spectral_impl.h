// SPDX-License-Identifier: MIT
// The spectral kernels but for the products (spectral_tiles.h). Included once per instruction set;
// see kernels_impl.h for what has to be defined and why nothing of the library is used.
#pragma once

#include <math.h>

#include "spectral_kernels.h"
#include "spectral_tiles.h"
#include "vector.h"

namespace mscomp::nn::MSCOMP_ISA {

constexpr int kChannels = 9;
/// Columns of partial sums of outer_9x9: the widest vector of any instruction set.
constexpr int kColumns = 16;

template <class T, class V, int R>
inline void laplacian_tile(const GraphMatrix<T>& matrix, const T* x, int row, T scale,
                           const T* previous, int v, T* out) {
    constexpr int n = width<T, V>();
    const std::int64_t own = static_cast<std::int64_t>(v) * row;
    V sums[R];
    for (int r = 0; r < R; ++r) sums[r] = matrix.diagonal * load<V>(x + own + r * n);
    for (int at = matrix.offsets[v]; at < matrix.offsets[v + 1]; ++at) {
        const T* from = x + static_cast<std::int64_t>(matrix.neighbors[at]) * row;
        const T weight = matrix.weights[at];
        for (int r = 0; r < R; ++r) sums[r] += weight * load<V>(from + r * n);
    }
    for (int r = 0; r < R; ++r) {
        V value = scale * sums[r];
        if (previous) value -= load<V>(previous + own + r * n);
        store(out + r * n, value);
    }
}

template <class T, class V>
void laplacian(const GraphMatrix<T>& matrix, const T* x, int row, T scale, const T* previous,
               int begin, int end, T* out) {
    constexpr int n = width<T, V>();
    for (int v = begin; v < end; ++v) {
        T* to = out + static_cast<std::int64_t>(v - begin) * row;
        in_even_tiles<9>(row / n, [&]<int R>(int r) {
            laplacian_tile<T, V, R>(matrix, x + r * n, row, scale,
                                    previous ? previous + r * n : nullptr, v, to + r * n);
        });
    }
}

template <class T, class V, int G>
inline void filter_tile(const T* const* terms, int order, const T* theta, bool use_tanh, int lanes,
                        std::int64_t at, T* y) {
    constexpr int n = width<T, V>();
    V sums[kChannels][G] = {};
    for (int h = 0; h < order; ++h) {
        const T* x = terms[h] + at;
        for (int c = 0; c < kChannels; ++c) {
            V input[G];
            for (int g = 0; g < G; ++g) input[g] = load<V>(x + c * lanes + g * n);
            for (int o = 0; o < kChannels; ++o) {
                const T weight = theta[(h * kChannels + c) * kChannels + o];
                for (int g = 0; g < G; ++g) sums[o][g] += weight * input[g];
            }
        }
    }
    for (int o = 0; o < kChannels; ++o) {
        for (int g = 0; g < G; ++g) {
            store(y + at + o * lanes + g * n, use_tanh ? tanh_of<T>(sums[o][g]) : sums[o][g]);
        }
    }
}

template <class T, class V>
void filter(const T* const* terms, int order, const T* theta, bool use_tanh, int lanes, int count,
            T* y) {
    constexpr int n = width<T, V>();
    constexpr int most = MSCOMP_VECTOR_BYTES == 64 ? tile_vectors<V>() : 1;
    for (int v = 0; v < count; ++v) {
        in_even_tiles<most>(lanes / n, [&]<int G>(int g) {
            filter_tile<T, V, G>(terms, order, theta, use_tanh, lanes,
                                 static_cast<std::int64_t>(v) * kChannels * lanes + g * n, y);
        });
    }
}

template <class T, class V>
void outer_9x9(const T* left, const T* right, int lanes, int count, T* sums) {
    constexpr int kTile = 3;
    for (int tile = 0; tile < kChannels; tile += kTile) {
        V tiled[kTile][kChannels];
        for (int c = 0; c < kTile; ++c) {
            for (int o = 0; o < kChannels; ++o) {
                tiled[c][o] = load<V>(sums + ((tile + c) * kChannels + o) * kColumns);
            }
        }
        for (int v = 0; v < count; ++v) {
            const T* a = left + (static_cast<std::int64_t>(v) * kChannels + tile) * lanes;
            const T* b = right + static_cast<std::int64_t>(v) * kChannels * lanes;
            for (int l = 0; l < lanes; l += width<T, V>()) {
                V from[kTile];
                for (int c = 0; c < kTile; ++c) from[c] = load<V>(a + c * lanes + l);
                for (int o = 0; o < kChannels; ++o) {
                    const V to = load<V>(b + o * lanes + l);
                    for (int c = 0; c < kTile; ++c) tiled[c][o] += from[c] * to;
                }
            }
        }
        for (int c = 0; c < kTile; ++c) {
            for (int o = 0; o < kChannels; ++o) {
                store(sums + ((tile + c) * kChannels + o) * kColumns, tiled[c][o]);
            }
        }
    }
}

template <class T, class V>
void tanh_slope(const T* y, std::int64_t count, T* slope) {
    for (std::int64_t i = 0; i < count; i += width<T, V>()) {
        const V out = load<V>(y + i), g = load<V>(slope + i);
        store(slope + i, g - g * out * out);
    }
}

template <class T, class V>
double error_slope(const T* x, const T* lane_weight, T factor, int lanes, int count, T* y) {
    V sum = {};
    for (int i = 0; i < count * kChannels; ++i) {
        const std::int64_t at = static_cast<std::int64_t>(i) * lanes;
        for (int l = 0; l < lanes; l += width<T, V>()) {
            const V weight = load<V>(lane_weight + l), out = load<V>(y + at + l);
            const V error = out - load<V>(x + at + l);
            const V weighted = weight * error;
            sum += weighted * error;
            const V g = factor * weighted;
            store(y + at + l, g - g * out * out);
        }
    }
    return static_cast<double>(horizontal_sum<T>(sum));
}

template <class T>
void lengths(const T* weights, int channels, int count, T* result) {
    for (int v = 0; v < count; ++v) {
        const T* at = weights + static_cast<std::int64_t>(v) * channels;
        T sum = 0;
        for (int c = 0; c < channels; ++c) sum += at[c] * at[c];
        result[v] = sum;
    }
    for (int v = 0; v < count; ++v) result[v] = static_cast<T>(sqrt(result[v]));
}

}  // namespace mscomp::nn::MSCOMP_ISA
