// SPDX-License-Identifier: MIT
// Register tiles of the products between component weights, rows and codes. Included once per
// instruction set; see kernels_impl.h for what has to be defined and why nothing of the library is
// used.
#pragma once

#include "vector.h"

namespace mscomp::nn::MSCOMP_ISA {

/// Most rows of a tile: with three vectors of lanes each, the sums of a tile fill the registers.
constexpr int kTileRows = MSCOMP_VECTOR_BYTES == 64 ? 8 : 4;

/// Vectors of lanes of a tile; half registers come with eight lanes only.
template <class V>
constexpr int tile_vectors() {
    return sizeof(V) == MSCOMP_VECTOR_BYTES ? 3 : 1;
}

// Weights are read in short runs, one for each component, which no processor foresees: the runs of
// the piece that follows, `count` further on, are fetched while this one is worked on.

/// Vectors that lie on no boundary.
template <class T, class V>
struct Unaligned {
    typedef V type __attribute__((aligned(sizeof(T)), may_alias));
};
template <class T, class V>
inline V load_unaligned(const T* from) {
    return *reinterpret_cast<const typename Unaligned<T, V>::type*>(from);
}
template <class T, class V>
inline void store_unaligned(T* to, V value) {
    *reinterpret_cast<typename Unaligned<T, V>::type*>(to) = value;
}

/// Calls call.operator()<size>(first) over [0, count) cut into as few tiles of at most Most as
/// possible, of nearly equal sizes.
template <int Most, class Call>
inline void in_even_tiles(int count, Call call) {
    int first = 0;
    for (int left = (count + Most - 1) / Most; left > 0; --left) {
        const int size = (count - first + left - 1) / left;
        if constexpr (Most >= 9) {
            if (size == 9) call.template operator()<9>(first);
        }
        if constexpr (Most >= 8) {
            if (size == 8) call.template operator()<8>(first);
            if (size == 7) call.template operator()<7>(first);
            if (size == 6) call.template operator()<6>(first);
            if (size == 5) call.template operator()<5>(first);
        }
        if constexpr (Most >= 4) {
            if (size == 4) call.template operator()<4>(first);
        }
        if constexpr (Most >= 3) {
            if (size == 3) call.template operator()<3>(first);
            if (size == 2) call.template operator()<2>(first);
        }
        if (size == 1) call.template operator()<1>(first);
        first += size;
    }
}

/// What a loop of `rounds` fetches, one line of the cache each round; `otherwise` again and again
/// where nothing is left.
struct Fetch {
    const char* at;
    std::int64_t step;
};
constexpr int kLine = 64;
inline Fetch next_fetch(Ahead& ahead, std::int64_t rounds, const void* otherwise) {
    if (ahead.done >= ahead.count * ahead.bytes) {
        return {static_cast<const char*>(otherwise), 0};
    }
    const Fetch fetch{ahead.pieces[ahead.done / ahead.bytes] + ahead.done % ahead.bytes, kLine};
    const std::int64_t left = ahead.bytes - ahead.done % ahead.bytes;
    ahead.done += rounds * kLine < left ? rounds * kLine : left;
    return fetch;
}

template <class T, class V, int R, int G>
inline void project_tile(const T* weights, std::int64_t stride, const T* rows, int lanes, int count,
                         Fetch fetch, T* codes) {
    constexpr int n = width<T, V>();
    V sums[R][G];
    for (int r = 0; r < R; ++r) {
        for (int g = 0; g < G; ++g) sums[r][g] = load<V>(codes + r * lanes + g * n);
    }
    constexpr int line = kLine / static_cast<int>(sizeof(T));
    for (int i = 0; i < count; ++i) {
        if (i % line == 0) {
            for (int r = 0; r < R; ++r) __builtin_prefetch(weights + r * stride + i + count);
        }
        __builtin_prefetch(fetch.at + i * fetch.step);
        V row[G];
        for (int g = 0; g < G; ++g) row[g] = load<V>(rows + i * lanes + g * n);
        for (int r = 0; r < R; ++r) {
            const T weight = weights[r * stride + i];
            for (int g = 0; g < G; ++g) sums[r][g] += weight * row[g];
        }
    }
    for (int r = 0; r < R; ++r) {
        for (int g = 0; g < G; ++g) store(codes + r * lanes + g * n, sums[r][g]);
    }
}

template <class T, class V>
void project(const T* weights, std::int64_t stride, int components, const T* rows, int lanes,
             int count, Ahead& ahead, T* codes) {
    constexpr int n = width<T, V>();
    in_even_tiles<tile_vectors<V>()>(lanes / n, [&]<int G>(int g) {
        in_even_tiles<kTileRows>(components, [&]<int R>(int k) {
            project_tile<T, V, R, G>(weights + k * stride, stride, rows + g * n, lanes, count,
                                     next_fetch(ahead, count, rows), codes + k * lanes + g * n);
        });
    });
}

template <class T, class V, int R, int G>
inline void expand_tile(const T* weights, std::int64_t stride, int components, const T* codes,
                        int lanes, int following, bool accumulate, Fetch fetch, T* rows) {
    constexpr int n = width<T, V>();
    V sums[R][G];
    for (int r = 0; r < R; ++r) {
        for (int g = 0; g < G; ++g) {
            sums[r][g] = accumulate ? load<V>(rows + r * lanes + g * n) : V{};
        }
    }
    for (int k = 0; k < components; ++k) {
        __builtin_prefetch(weights + k * stride + following);
        __builtin_prefetch(fetch.at + k * fetch.step);
        V code[G];
        for (int g = 0; g < G; ++g) code[g] = load<V>(codes + k * lanes + g * n);
        for (int r = 0; r < R; ++r) {
            const T weight = weights[k * stride + r];
            for (int g = 0; g < G; ++g) sums[r][g] += weight * code[g];
        }
    }
    for (int r = 0; r < R; ++r) {
        for (int g = 0; g < G; ++g) store(rows + r * lanes + g * n, sums[r][g]);
    }
}

template <class T, class V>
void expand(const T* weights, std::int64_t stride, int components, const T* codes, int lanes,
            int count, bool accumulate, Ahead& ahead, T* rows) {
    constexpr int n = width<T, V>();
    in_even_tiles<tile_vectors<V>()>(lanes / n, [&]<int G>(int g) {
        in_even_tiles<kTileRows>(count, [&]<int R>(int i) {
            expand_tile<T, V, R, G>(weights + i, stride, components, codes + g * n, lanes, count,
                                    accumulate, next_fetch(ahead, components, codes),
                                    rows + i * lanes + g * n);
        });
    });
}

template <class T, class V, int R, int G>
inline void outer_tile(const T* codes, int padded, const T* rows, int lanes, int active, T* out) {
    constexpr int n = width<T, V>();
    V sums[R][G] = {};
    for (int l = 0; l < active; ++l) {
        V code[G];
        for (int g = 0; g < G; ++g) code[g] = load<V>(codes + l * padded + g * n);
        for (int r = 0; r < R; ++r) {
            const T row = rows[r * lanes + l];
            for (int g = 0; g < G; ++g) sums[r][g] += row * code[g];
        }
    }
    for (int r = 0; r < R; ++r) {
        for (int g = 0; g < G; ++g) store(out + r * padded + g * n, sums[r][g]);
    }
}

template <int... I>
struct Indices {};
template <int N, int... I>
struct IndicesBelow : IndicesBelow<N - 1, N - 1, I...> {};
template <int... I>
struct IndicesBelow<0, I...> {
    using type = Indices<I...>;
};

/// a0 b0 a1 b1 ... of the lower or the upper halves.
template <bool Upper, class V, int... I>
inline V interleaved(V a, V b, Indices<I...>) {
    constexpr int n = static_cast<int>(sizeof...(I));
    return __builtin_shufflevector(a, b, ((Upper ? n / 2 : 0) + I / 2 + I % 2 * n)...);
}

/// Transposes a square of N rows: log2 N rounds, each interleaving row i with row i + N/2.
template <class V, int N>
inline void transpose(V* square) {
    typename IndicesBelow<N>::type indices;
    for (int round = 1; round < N; round *= 2) {
        V next[N];
        for (int i = 0; i < N / 2; ++i) {
            next[2 * i] = interleaved<false>(square[i], square[i + N / 2], indices);
            next[2 * i + 1] = interleaved<true>(square[i], square[i + N / 2], indices);
        }
        for (int i = 0; i < N; ++i) square[i] = next[i];
    }
}

/// grad[k stride + i] += products[i][k].
template <class T, class V>
void add_transposed(const T* products, int padded, int components, int count, std::int64_t stride,
                    T* grad) {
    constexpr int n = width<T, V>();
    int i = 0;
    for (; i + n <= count; i += n) {
        for (int k = 0; k < components; k += n) {
            V square[n];
            for (int r = 0; r < n; ++r) square[r] = load<V>(products + (i + r) * padded + k);
            transpose<V, n>(square);
            for (int r = 0; r < n && k + r < components; ++r) {
                T* target = grad + (k + r) * stride + i;
                __builtin_prefetch(target + count, 1);
                store_unaligned<T, V>(target, load_unaligned<T, V>(target) + square[r]);
            }
        }
    }
    for (; i < count; ++i) {
        for (int k = 0; k < components; ++k) grad[k * stride + i] += products[i * padded + k];
    }
}

template <class T, class V>
void outer(const T* codes, int padded, int components, const T* rows, int lanes, int active,
           int count, T* scratch, std::int64_t stride, T* grad) {
    constexpr int n = width<T, V>();
    const int vectors = (components + n - 1) / n;
    in_even_tiles<3>(vectors, [&]<int G>(int g) {
        in_even_tiles<kTileRows>(count, [&]<int R>(int i) {
            outer_tile<T, V, R, G>(codes + g * n, padded, rows + i * lanes, lanes, active,
                                   scratch + i * padded + g * n);
        });
    });
    add_transposed<T, V>(scratch, padded, components, count, stride, grad);
}

}  // namespace mscomp::nn::MSCOMP_ISA
