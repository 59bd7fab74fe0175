// SPDX-License-Identifier: MIT
// Compiler vector types of a given number of elements, in the namespace MSCOMP_ISA of the including
// instruction set.
#pragma once

#include <math.h>
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include <cstdint>

namespace mscomp::nn::MSCOMP_ISA {

template <class T, int N>
struct VectorOf {
    typedef T type __attribute__((vector_size(N * sizeof(T)), may_alias));
};

/// The same anywhere in memory.
template <class T, int N>
struct UnalignedOf {
    typedef T type __attribute__((vector_size(N * sizeof(T)), may_alias, aligned(alignof(T))));
};

template <class T, class V>
constexpr int width() {
    return static_cast<int>(sizeof(V) / sizeof(T));
}

template <class V, class T>
inline V load(const T* from) {
    return *reinterpret_cast<const V*>(from);
}

template <class V, class T>
inline void store(T* to, V value) {
    *reinterpret_cast<V*>(to) = value;
}

template <class V, class T>
inline V splat(T value) {
    return V{} + value;
}

/// Sum of the elements by halves, always in the same order.
template <class T, class V>
inline T horizontal_sum(V v) {
    constexpr int n = width<T, V>();
    if constexpr (n == 2) {
        return v[0] + v[1];
    } else {
        using Halved = typename VectorOf<T, n / 2>::type;
        const Halved* halves = reinterpret_cast<const Halved*>(&v);
        return horizontal_sum<T, Halved>(halves[0] + halves[1]);
    }
}

/// 1 / x of every element for x in [1, 2]: where division is slow, an estimate of 14 bits and one
/// Newton step, which is right to a unit in the last place.
template <class T, class V>
inline V reciprocal(V x) {
#if defined(__AVX512F__)
    if constexpr (sizeof(T) == 4 && sizeof(V) == 64) {
        const V estimate =
            reinterpret_cast<V>(_mm512_maskz_rcp14_ps(0xFFFF, reinterpret_cast<__m512>(x)));
        return estimate + estimate * (T{1} - x * estimate);
    }
#endif
    return T{1} / x;
}

/// tanh of every element. Float: -expm1(-2|x|) / (2 + expm1(-2|x|)) with expm1 by reduction to
/// |r| <= ln2/2 and its Taylor polynomial of degree 7; relative error below 3e-7. NaN stays NaN.
template <class T, class V>
inline V tanh_of(V x) {
    constexpr int n = width<T, V>();
    if constexpr (sizeof(T) == 8) {
        for (int i = 0; i < n; ++i) x[i] = tanh(x[i]);
        return x;
    } else {
        using Int = typename VectorOf<std::int32_t, n>::type;
        const V magnitude = x < 0 ? -x : x;
        const V doubled = -2.0f * magnitude;
        const V y = doubled < -60.0f ? splat<V>(-60.0f) : doubled;
        constexpr float kRounder = 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer
        const V whole = (y * 1.44269504f + kRounder) - kRounder;
        // ln 2 in two parts, the first with trailing zeros so that whole * part is exact.
        const V r = (y - whole * 0.693145752f) - whole * 1.42860677e-06f;
        V p = 1.0f / 5040 * r + 1.0f / 720;
        p = p * r + 1.0f / 120;
        p = p * r + 1.0f / 24;
        p = p * r + 1.0f / 6;
        p = p * r + 0.5f;
        p = p * r * r + r;
        const Int exponent = (__builtin_convertvector(whole, Int) + 127) << 23;
        const V scale = reinterpret_cast<V>(exponent);
        const V expm1 = scale * p + (scale - 1.0f);
        const V result = -expm1 * reciprocal<T>(2.0f + expm1);
        return x < 0 ? -result : result;
    }
}

}  // namespace mscomp::nn::MSCOMP_ISA
