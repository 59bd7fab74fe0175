// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

// The inner loops of the spectral ops, compiled once per instruction set like those of kernels.h
// and picked with them.
//
// Rows are [vertex][channel][lanes], lanes a multiple of 8, on 64-byte boundaries; component
// weights are [k][vertex][channel], on no boundary; codes are [k][lanes]. Kernels work on a piece
// of consecutive rows and touch no shared output, so that callers decide about threads.
namespace mscomp::nn {

/// A symmetric matrix over vertices: `diagonal` on the diagonal, weights[n] at neighbors[n].
template <class T>
struct GraphMatrix {
    int vertices;
    const int* offsets;
    const int* neighbors;
    const T* weights;
    T diagonal;
};

/// Memory that is needed soon: a kernel that computes much and reads little fetches as much of it
/// on the way as it can, and counts it in `done`. Says nothing about results.
struct Ahead {
    const char* pieces[4] = {};
    int count = 0;
    std::int64_t bytes = 0;  // of each piece
    std::int64_t done = 0;   // of all pieces
};

template <class T>
struct SpectralKernels {
    const char* instruction_set;

    /// out_v = scale (M x)_v - previous_v for v in [begin, end); `row` numbers per vertex, `out`
    /// starts at vertex begin, x and previous (null: 0) at vertex 0.
    void (*laplacian)(const GraphMatrix<T>& matrix, const T* x, int row, T scale, const T* previous,
                      int begin, int end, T* out);
    /// y_v = act(sum_h terms[h]_v theta_h) for `count` vertices; theta [order][9 in][9 out].
    void (*filter)(const T* const* terms, int order, const T* theta, bool use_tanh, int lanes,
                   int count, T* y);
    /// sums[c][o] += left[c] right[o] over `count` vertices and lanes; sums [9][9][16] are partial
    /// sums over 16 columns, to be added up by the caller.
    void (*outer_9x9)(const T* left, const T* right, int lanes, int count, T* sums);
    /// slope *= 1 - y^2, y the tanh.
    void (*tanh_slope)(const T* y, std::int64_t count, T* slope);
    /// Returns sum of lane_weight (x - y)^2 and turns the tanh y into
    /// factor lane_weight (y - x) (1 - y^2).
    double (*error_slope)(const T* x, const T* lane_weight, T factor, int lanes, int count, T* y);
    /// codes[k] += sum_i weights[k stride + i] rows[i], i < count.
    void (*project)(const T* weights, std::int64_t stride, int components, const T* rows, int lanes,
                    int count, Ahead& ahead, T* codes);
    /// rows[i] (+)= sum_k weights[k stride + i] codes[k], i < count.
    void (*expand)(const T* weights, std::int64_t stride, int components, const T* codes, int lanes,
                   int count, bool accumulate, Ahead& ahead, T* rows);
    /// grad[k stride + i] += sum_{l < active} codes[l][k] rows[i][l], i < count; codes are
    /// [active][padded], padded a multiple of 16; scratch holds count * padded numbers.
    void (*outer)(const T* codes, int padded, int components, const T* rows, int lanes, int active,
                  int count, T* scratch, std::int64_t stride, T* grad);
    /// lengths[v] = |weights_v|, `channels` numbers per vertex; returns the first longest.
    int (*lengths)(const T* weights, int channels, int count, T* lengths);
    /// Sum of the lengths at vertices whose distance exceeds `range`.
    double (*outside)(const double* distances, const T* lengths, double range, int count);
    /// weights_v *= max(0, 1 - sqrt(bound / (sum of moment2_v) / lengths_v^2)) where the distance
    /// exceeds `range` and the length is not 0; 0 where moment2 is.
    void (*shrink)(const T* moment2, const double* distances, const T* lengths, double range,
                   T bound, int channels, int count, T* weights);
};

/// The kernels of the instruction set that kernels<T>() has picked.
template <class T>
const SpectralKernels<T>& spectral_kernels();
/// Those of "generic", "avx2" or "avx512"; null where the processor lacks it.
template <class T>
const SpectralKernels<T>* find_spectral_kernels(const char* instruction_set);

namespace isa_generic {
template <class T>
SpectralKernels<T> spectral_table();
}
namespace isa_avx2 {
template <class T>
SpectralKernels<T> spectral_table();
}
namespace isa_avx512 {
template <class T>
SpectralKernels<T> spectral_table();
}

}  // namespace mscomp::nn
