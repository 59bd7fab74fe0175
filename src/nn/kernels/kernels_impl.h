// SPDX-License-Identifier: MIT
// The kernels themselves. Included once per instruction set with MSCOMP_ISA (a namespace) and
// MSCOMP_VECTOR_BYTES defined. Uses the compiler's vector types and no library templates: an inline
// function of a shared header, compiled here with wider instructions, could be the copy that the
// linker keeps for everybody.
#pragma once

#include <math.h>

#include "kernels.h"
#include "vector.h"

namespace mscomp::nn::MSCOMP_ISA {

constexpr int kDim = 9;

template <class V, class T>
inline void apply_pair(const T* mp, const T* mn, const T* bias, const V* x, const V* n, V* out) {
    for (int o = 0; o < kDim; ++o) {
        V sum = bias ? splat<V>(bias[o]) : V{};
        for (int c = 0; c < kDim; ++c) sum += mp[o * kDim + c] * x[c];
        for (int c = 0; c < kDim; ++c) sum += mn[o * kDim + c] * n[c];
        out[o] = sum;
    }
}

/// sums[c] = sum over the ring of v of weight_j rows_j[c], weight_j = 1 without `weight`.
template <class V, class T>
inline void gather(const Neighborhood<T>& rings, const T* rows, const T* weight, int lanes, int l,
                   int v, V* sums) {
    for (int c = 0; c < kDim; ++c) sums[c] = V{};
    for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
        const int j = rings.neighbors[at];
        const T* row = rows + static_cast<std::int64_t>(j) * kDim * lanes + l;
        if (weight) {
            const T w = weight[j];
            for (int c = 0; c < kDim; ++c) sums[c] += w * load<V>(row + c * lanes);
        } else {
            for (int c = 0; c < kDim; ++c) sums[c] += load<V>(row + c * lanes);
        }
    }
}

template <class T, class V>
void conv_forward(const Neighborhood<T>& rings, const T* x, const T* mp, const T* mn, const T* bias,
                  bool use_tanh, int lanes, int begin, int end, T* y) {
    for (int v = begin; v < end; ++v) {
        const std::int64_t at = static_cast<std::int64_t>(v) * kDim * lanes;
        for (int l = 0; l < lanes; l += width<T, V>()) {
            V own[kDim], mean[kDim], out[kDim];
            gather<V, T>(rings, x, nullptr, lanes, l, v, mean);
            for (int c = 0; c < kDim; ++c) {
                mean[c] *= rings.inverse_degree[v];
                own[c] = load<V>(x + at + c * lanes + l);
            }
            apply_pair<V, T>(mp, mn, bias, own, mean, out);
            for (int c = 0; c < kDim; ++c) {
                store(y + at + c * lanes + l, use_tanh ? tanh_of<T>(out[c]) : out[c]);
            }
        }
    }
}

template <class T, class V>
void conv_backward_activation(const T* y, const T* dy, bool use_tanh, int lanes, int begin, int end,
                              T* dpre, T* bias_grad) {
    V sums[kDim] = {};
    for (int v = begin; v < end; ++v) {
        for (int c = 0; c < kDim; ++c) {
            const std::int64_t at = (static_cast<std::int64_t>(v) * kDim + c) * lanes;
            for (int l = 0; l < lanes; l += width<T, V>()) {
                V g = load<V>(dy + at + l);
                if (use_tanh) {
                    const V out = load<V>(y + at + l);
                    g = g - g * out * out;
                }
                store(dpre + at + l, g);
                sums[c] += g;
            }
        }
    }
    for (int c = 0; c < kDim; ++c) bias_grad[c] += horizontal_sum<T>(sums[c]);
}

/// sums[o][c] += sum over rows and lanes of a[o] b[c], the lanes of a register apart; as many rows
/// of the result at a time as stay in registers.
template <class T, class V>
inline void add_outer_9x9(const T* a, const T* b, std::int64_t rows, int lanes, V* sums) {
    constexpr int kTile = MSCOMP_VECTOR_BYTES == 64 ? 3 : 1;
    for (int tile = 0; tile < kDim; tile += kTile) {
        V tile_sums[kTile][kDim];
        for (int o = 0; o < kTile; ++o) {
            for (int c = 0; c < kDim; ++c) tile_sums[o][c] = sums[(tile + o) * kDim + c];
        }
        for (std::int64_t row = 0; row < rows; ++row) {
            const T* ra = a + (row * kDim + tile) * lanes;
            const T* rb = b + row * kDim * lanes;
            for (int l = 0; l < lanes; l += width<T, V>()) {
                V left[kTile];
                for (int o = 0; o < kTile; ++o) left[o] = load<V>(ra + o * lanes + l);
                for (int c = 0; c < kDim; ++c) {
                    const V right = load<V>(rb + c * lanes + l);
                    for (int o = 0; o < kTile; ++o) tile_sums[o][c] += left[o] * right;
                }
            }
        }
        for (int o = 0; o < kTile; ++o) {
            for (int c = 0; c < kDim; ++c) sums[(tile + o) * kDim + c] = tile_sums[o][c];
        }
    }
}

template <class T>
inline void transpose_9x9(const T* from, T* to) {
    for (int o = 0; o < kDim; ++o) {
        for (int c = 0; c < kDim; ++c) to[c * kDim + o] = from[o * kDim + c];
    }
}

template <class T, class V>
void conv_backward(const Neighborhood<T>& rings, const T* x, const T* dpre, const T* mp,
                   const T* mn, int lanes, int begin, int end, T* scratch, T* dx, T* mp_grad,
                   T* mn_grad) {
    T mp_t[kDim * kDim], mn_t[kDim * kDim];
    transpose_9x9(mp, mp_t);
    transpose_9x9(mn, mn_t);
    for (int v = begin; v < end; ++v) {
        const std::int64_t at = static_cast<std::int64_t>(v) * kDim * lanes;
        T* gathered = scratch + static_cast<std::int64_t>(v - begin) * kDim * lanes;
        for (int l = 0; l < lanes; l += width<T, V>()) {
            V own[kDim], ring[kDim], out[kDim];
            gather<V, T>(rings, dpre, rings.inverse_degree, lanes, l, v, ring);
            for (int c = 0; c < kDim; ++c) store(gathered + c * lanes + l, ring[c]);
            if (!dx) continue;
            for (int c = 0; c < kDim; ++c) own[c] = load<V>(dpre + at + c * lanes + l);
            apply_pair<V, T>(mp_t, mn_t, nullptr, own, ring, out);
            for (int c = 0; c < kDim; ++c) {
                T* target = dx + at + c * lanes + l;
                store(target, load<V>(target) + out[c]);
            }
        }
    }
    const std::int64_t first = static_cast<std::int64_t>(begin) * kDim * lanes;
    V mp_sums[kDim * kDim] = {}, mn_sums[kDim * kDim] = {};
    add_outer_9x9<T, V>(dpre + first, x + first, end - begin, lanes, mp_sums);
    add_outer_9x9<T, V>(scratch, x + first, end - begin, lanes, mn_sums);
    for (int i = 0; i < kDim * kDim; ++i) {
        mp_grad[i] += horizontal_sum<T>(mp_sums[i]);
        mn_grad[i] += horizontal_sum<T>(mn_sums[i]);
    }
}

template <class T, class V, int K>
void project_tile(const T* weights, std::int64_t stride, const T* rows, int lanes, int begin,
                  int end, T* codes) {
    for (int l = 0; l < lanes; l += width<T, V>()) {
        V sums[K] = {};
        for (std::int64_t i = static_cast<std::int64_t>(begin) * kDim;
             i < static_cast<std::int64_t>(end) * kDim; ++i) {
            const V row = load<V>(rows + i * lanes + l);
            for (int k = 0; k < K; ++k) sums[k] += weights[k * stride + i] * row;
        }
        for (int k = 0; k < K; ++k) {
            store(codes + k * lanes + l, load<V>(codes + k * lanes + l) + sums[k]);
        }
    }
}

template <class T, class V, int K>
void expand_tile(const T* weights, std::int64_t stride, const T* codes, int lanes, int begin,
                 int end, bool accumulate, T* rows) {
    for (int l = 0; l < lanes; l += width<T, V>()) {
        V code[K];
        for (int k = 0; k < K; ++k) code[k] = load<V>(codes + k * lanes + l);
        for (std::int64_t i = static_cast<std::int64_t>(begin) * kDim;
             i < static_cast<std::int64_t>(end) * kDim; ++i) {
            V sum = accumulate ? load<V>(rows + i * lanes + l) : V{};
            for (int k = 0; k < K; ++k) sum += weights[k * stride + i] * code[k];
            store(rows + i * lanes + l, sum);
        }
    }
}

template <class T, class V, int K>
void outer_tile(const T* codes, const T* rows, std::int64_t stride, int lanes, int begin, int end,
                T* weights_grad) {
    for (std::int64_t i = static_cast<std::int64_t>(begin) * kDim;
         i < static_cast<std::int64_t>(end) * kDim; ++i) {
        V sums[K] = {};
        for (int l = 0; l < lanes; l += width<T, V>()) {
            const V row = load<V>(rows + i * lanes + l);
            for (int k = 0; k < K; ++k) sums[k] += load<V>(codes + k * lanes + l) * row;
        }
        for (int k = 0; k < K; ++k) weights_grad[k * stride + i] += horizontal_sum<T>(sums[k]);
    }
}

/// Calls call.operator()<K>(first) over components in tiles of a compile-time size.
template <class Call>
inline void in_tiles(int components, Call call) {
    int first = 0;
    for (; components - first >= 10; first += 10) call.template operator()<10>(first);
    switch (components - first) {
        case 9:
            call.template operator()<9>(first);
            break;
        case 8:
            call.template operator()<8>(first);
            break;
        case 7:
            call.template operator()<7>(first);
            break;
        case 6:
            call.template operator()<6>(first);
            break;
        case 5:
            call.template operator()<5>(first);
            break;
        case 4:
            call.template operator()<4>(first);
            break;
        case 3:
            call.template operator()<3>(first);
            break;
        case 2:
            call.template operator()<2>(first);
            break;
        case 1:
            call.template operator()<1>(first);
            break;
        default:
            break;
    }
}

template <class T, class V>
void project(const T* weights, std::int64_t stride, int components, const T* rows, int lanes,
             int begin, int end, T* codes) {
    in_tiles(components, [&]<int K>(int k) {
        project_tile<T, V, K>(weights + k * stride, stride, rows, lanes, begin, end,
                              codes + k * lanes);
    });
}

template <class T, class V>
void expand(const T* weights, std::int64_t stride, int components, const T* codes, int lanes,
            int begin, int end, bool accumulate, T* rows) {
    in_tiles(components, [&]<int K>(int k) {
        expand_tile<T, V, K>(weights + k * stride, stride, codes + k * lanes, lanes, begin, end,
                             accumulate || k > 0, rows);
    });
}

template <class T, class V>
void outer(const T* codes, const T* rows, std::int64_t stride, int components, int lanes, int begin,
           int end, T* weights_grad) {
    in_tiles(components, [&]<int K>(int k) {
        outer_tile<T, V, K>(codes + k * lanes, rows, stride, lanes, begin, end,
                            weights_grad + k * stride);
    });
}

template <class T, class V>
double squared_error(const T* x, const T* y, const T* lane_weight, int lanes, int begin, int end) {
    double total = 0;
    for (int v = begin; v < end; ++v) {
        V sum = {};
        for (int c = 0; c < kDim; ++c) {
            const std::int64_t at = (static_cast<std::int64_t>(v) * kDim + c) * lanes;
            for (int l = 0; l < lanes; l += width<T, V>()) {
                const V difference = load<V>(x + at + l) - load<V>(y + at + l);
                sum += load<V>(lane_weight + l) * difference * difference;
            }
        }
        total += static_cast<double>(horizontal_sum<T>(sum));
    }
    return total;
}

template <class T, class V>
void squared_error_backward(const T* x, const T* y, const T* lane_weight, T factor, int lanes,
                            int begin, int end, T* dx, T* dy) {
    for (std::int64_t i = static_cast<std::int64_t>(begin) * kDim;
         i < static_cast<std::int64_t>(end) * kDim; ++i) {
        for (int l = 0; l < lanes; l += width<T, V>()) {
            const std::int64_t at = i * lanes + l;
            const V g = factor * load<V>(lane_weight + l) * (load<V>(x + at) - load<V>(y + at));
            if (dx) store(dx + at, load<V>(dx + at) + g);
            if (dy) store(dy + at, load<V>(dy + at) - g);
        }
    }
}

template <class T, class V>
void masked_residual(const T* x, const T* y, const T* mask, int lanes, int begin, int end, T* out) {
    for (int v = begin; v < end; ++v) {
        const std::int64_t first = static_cast<std::int64_t>(v) * kDim * lanes;
        const T weight = mask ? mask[v] : T{1};
        for (int l = 0; l < kDim * lanes; l += width<T, V>()) {
            store(out + first + l, weight * (load<V>(x + first + l) - load<V>(y + first + l)));
        }
    }
}

template <class T, class V>
void masked_residual_backward(const T* x, const T* y, const T* mask, const T* dout, int lanes,
                              int begin, int end, T* dx, T* dy, T* dmask) {
    for (int v = begin; v < end; ++v) {
        const std::int64_t first = static_cast<std::int64_t>(v) * kDim * lanes;
        const T weight = mask ? mask[v] : T{1};
        V sum = {};
        for (int l = 0; l < kDim * lanes; l += width<T, V>()) {
            const std::int64_t at = first + l;
            const V g = load<V>(dout + at);
            if (dmask) sum += g * (load<V>(x + at) - load<V>(y + at));
            if (dx) store(dx + at, load<V>(dx + at) + weight * g);
            if (dy) store(dy + at, load<V>(dy + at) - weight * g);
        }
        if (dmask) dmask[v] += horizontal_sum<T>(sum);
    }
}

template <class T, class V>
void tanh_forward(const T* x, std::int64_t count, T* y) {
    constexpr int n = width<T, V>();
    std::int64_t i = 0;
    for (; i + n <= count; i += n) store(y + i, tanh_of<T>(load<V>(x + i)));
    if (i == count) return;
    V rest = {};
    for (int j = 0; i + j < count; ++j) rest[j] = x[i + j];
    rest = tanh_of<T>(rest);
    for (int j = 0; i + j < count; ++j) y[i + j] = rest[j];
}

template <class T, class V>
T zero_sum(const T* x, std::int64_t count) {
    constexpr int n = width<T, V>();
    using Unaligned = typename UnalignedOf<T, n>::type;
    V sum = {};
    std::int64_t i = 0;
    for (; i + n <= count; i += n) {
        sum += T{0} * *reinterpret_cast<const Unaligned*>(x + i);
    }
    T rest = 0;
    for (; i < count; ++i) rest += T{0} * x[i];
    return horizontal_sum<T>(sum) + rest;
}

template <class T>
void adam(T* __restrict p, T* __restrict m, T* __restrict v, const T* __restrict g,
          std::int64_t count, T rate, T beta1, T beta2, T correction1, T correction2, T epsilon) {
    for (std::int64_t i = 0; i < count; ++i) {
        m[i] = beta1 * m[i] + (1 - beta1) * g[i];
        v[i] = beta2 * v[i] + (1 - beta2) * g[i] * g[i];
        p[i] -= rate * (m[i] / correction1) / (static_cast<T>(sqrt(v[i] / correction2)) + epsilon);
    }
}

}  // namespace mscomp::nn::MSCOMP_ISA
