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

/// Of so many vertices beside each other and their rings, a part of each row fits the first cache.
constexpr int kTogether = 16;

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
    // The highest neighbour of a vertex is the one that no vertex before has touched.
    const int later = v + kTogether;
    if (later < matrix.vertices && matrix.offsets[later] < matrix.offsets[later + 1]) {
        const std::int64_t highest = matrix.neighbors[matrix.offsets[later + 1] - 1];
        for (int r = 0; r < R; ++r) __builtin_prefetch(x + highest * row + r * n);
        for (int r = 0; r < R; ++r) __builtin_prefetch(out + kTogether * row + r * n, 1);
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
    for (int first = begin; first < end; first += kTogether) {
        const int last = first + kTogether < end ? first + kTogether : end;
        in_even_tiles<9>(row / n, [&]<int R>(int r) {
            for (int v = first; v < last; ++v) {
                laplacian_tile<T, V, R>(matrix, x + r * n, row, scale,
                                        previous ? previous + r * n : nullptr, v,
                                        out + static_cast<std::int64_t>(v - begin) * row + r * n);
            }
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

/// result[v] = sum of the numbers of vertex v, or of their squares. Nine channels are the usual
/// case, and known to the compiler there.
template <class T, int Channels>
void vertex_sums(const T* numbers, bool squared, int channels, int count, T* result) {
    const int n = Channels > 0 ? Channels : channels;
    for (int v = 0; v < count; ++v) {
        const T* at = numbers + static_cast<std::int64_t>(v) * n;
        T sum = 0;
        for (int c = 0; c < n; ++c) sum += squared ? at[c] * at[c] : at[c];
        result[v] = sum;
    }
}
template <class T>
void vertex_sums(const T* numbers, bool squared, int channels, int count, T* result) {
    if (channels == kChannels) {
        vertex_sums<T, kChannels>(numbers, squared, channels, count, result);
    } else {
        vertex_sums<T, 0>(numbers, squared, channels, count, result);
    }
}

/// numbers of vertex v *= factors[v].
template <class T, int Channels>
void scale_vertices(const T* factors, int channels, int count, T* numbers) {
    const int n = Channels > 0 ? Channels : channels;
    for (int v = 0; v < count; ++v) {
        T* at = numbers + static_cast<std::int64_t>(v) * n;
        for (int c = 0; c < n; ++c) at[c] *= factors[v];
    }
}

template <class T>
int lengths(const T* weights, int channels, int count, T* result) {
    vertex_sums(weights, true, channels, count, result);
    T largest = 0;
    for (int v = 0; v < count; ++v) {
        result[v] = static_cast<T>(sqrt(result[v]));
        largest = result[v] > largest ? result[v] : largest;
    }
    for (int v = 0; v < count; ++v) {
        if (result[v] == largest) return v;
    }
    return 0;  // not a number
}

template <class T>
double outside(const double* distances, const T* lengths, double range, int count) {
    constexpr int n = MSCOMP_VECTOR_BYTES / static_cast<int>(sizeof(double));
    using Doubles = typename VectorOf<double, n>::type;
    using Lengths = typename VectorOf<T, n>::type;
    Doubles sums = {};
    int v = 0;
    for (; v + n <= count; v += n) {
        const Doubles distance = load_unaligned<double, Doubles>(distances + v);
        const Doubles length =
            __builtin_convertvector(load_unaligned<T, Lengths>(lengths + v), Doubles);
        sums += distance > range ? length : Doubles{};
    }
    double sum = horizontal_sum<double>(sums);
    for (; v < count; ++v) sum += distances[v] > range ? static_cast<double>(lengths[v]) : 0.0;
    return sum;
}

template <class T>
void shrink(const T* moment2, const double* distances, const T* lengths, double range, T bound,
            int channels, int count, T* weights) {
    constexpr int kBlock = 64;
    for (int first = 0; first < count; first += kBlock) {
        const int size = count - first < kBlock ? count - first : kBlock;
        T keep[kBlock];
        bool changes = false;
        for (int i = 0; i < size; ++i) {
            const bool is_shrunk = distances[first + i] > range && lengths[first + i] > 0;
            keep[i] = is_shrunk ? T{0} : T{1};
            changes |= is_shrunk;
        }
        if (!changes) continue;
        T squares[kBlock];
        const std::int64_t at = static_cast<std::int64_t>(first) * channels;
        vertex_sums(moment2 + at, false, channels, size, squares);
        for (int i = 0; i < size; ++i) squares[i] *= lengths[first + i] * lengths[first + i];
        for (int i = 0; i < size; ++i) {
            const T share =
                squares[i] > bound ? 1 - static_cast<T>(sqrt(bound / squares[i])) : T{0};
            keep[i] = keep[i] > 0 ? keep[i] : share;
        }
        if (channels == kChannels) {
            scale_vertices<T, kChannels>(keep, channels, size, weights + at);
        } else {
            scale_vertices<T, 0>(keep, channels, size, weights + at);
        }
    }
}

}  // namespace mscomp::nn::MSCOMP_ISA
