// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "autoencoder_kernels.h"

// The inner loops of the ops, compiled once per instruction set and picked at run time.
//
// Layout of everything per vertex: rows [vertex][9][lanes], lanes = shapes of the batch, a multiple
// of 8, on 64-byte boundaries. A vertex is then a tiny matrix times lanes. Component weights are
// [k][vertex][9], codes [k][lanes]. All kernels work on vertices [begin, end) of one autoencoder
// and touch no shared output, so that callers decide about threads.
namespace mscomp::nn {

/// One-rings and the reciprocal degrees (0 for isolated vertices).
template <class T>
struct Neighborhood {
    const int* offsets;
    const int* neighbors;
    const T* inverse_degree;
};

template <class T>
struct Kernels {
    const char* instruction_set;

    /// y_v = act(Mp x_v + Mn mean_{N(v)} x + b); Mp, Mn row-major [9][9].
    void (*conv_forward)(const Neighborhood<T>& rings, const T* x, const T* mp, const T* mn,
                         const T* bias, bool use_tanh, int lanes, int begin, int end, T* y);
    /// dpre = dy (1 - y^2) where use_tanh, else dy; bias_grad[9] += its sums.
    void (*conv_backward_activation)(const T* y, const T* dy, bool use_tanh, int lanes, int begin,
                                     int end, T* dpre, T* bias_grad);
    /// From dpre of all vertices: dx_v += Mp^T dpre_v + Mn^T g_v (where dx is given) and
    /// mp_grad += dpre x^T, mn_grad += g x^T, with g_v = sum_{N(v)} dpre_j / deg(j).
    /// scratch holds (end - begin) rows.
    void (*conv_backward)(const Neighborhood<T>& rings, const T* x, const T* dpre, const T* mp,
                          const T* mn, int lanes, int begin, int end, T* scratch, T* dx, T* mp_grad,
                          T* mn_grad);
    /// codes[k] += sum_v sum_c weights[k][v][c] rows[v][c]; `stride` = 9 V between components.
    void (*project)(const T* weights, std::int64_t stride, int components, const T* rows, int lanes,
                    int begin, int end, T* codes);
    /// rows[v][c] (+)= sum_k weights[k][v][c] codes[k].
    void (*expand)(const T* weights, std::int64_t stride, int components, const T* codes, int lanes,
                   int begin, int end, bool accumulate, T* rows);
    /// weights_grad[k][v][c] += sum_lanes codes[k] rows[v][c].
    void (*outer)(const T* codes, const T* rows, std::int64_t stride, int components, int lanes,
                  int begin, int end, T* weights_grad);
    /// Sum of lane_weight (x - y)^2.
    double (*squared_error)(const T* x, const T* y, const T* lane_weight, int lanes, int begin,
                            int end);
    /// g = factor lane_weight (x - y); dx += g and dy -= g, each where given.
    void (*squared_error_backward)(const T* x, const T* y, const T* lane_weight, T factor,
                                   int lanes, int begin, int end, T* dx, T* dy);
    /// out_v = mask_v (x_v - y_v).
    void (*masked_residual)(const T* x, const T* y, const T* mask, int lanes, int begin, int end,
                            T* out);
    /// dx += mask dout, dy -= mask dout (where given); dmask_v += sum dout (x - y) (where given).
    void (*masked_residual_backward)(const T* x, const T* y, const T* mask, const T* dout,
                                     int lanes, int begin, int end, T* dx, T* dy, T* dmask);
    AutoencoderKernels<T> autoencoder;
    /// y = tanh(x) for any number of values.
    void (*tanh_forward)(const T* x, std::int64_t count, T* y);
    /// Sum of 0 x: 0 where all values are finite, NaN otherwise.
    T (*zero_sum)(const T* x, std::int64_t count);
    /// One Adam update: m, v, p from g; correction1 = 1 - beta1^t, correction2 = 1 - beta2^t.
    void (*adam)(T* p, T* m, T* v, const T* g, std::int64_t count, T rate, T beta1, T beta2,
                 T correction1, T correction2, T epsilon);
};

/// The kernels for this processor; "generic", "avx2" or "avx512" asks for one of them, and gets
/// null where the processor lacks it. The environment variable MSCOMP_INSTRUCTION_SET does so for a
/// run.
template <class T>
const Kernels<T>& kernels();
template <class T>
const Kernels<T>* find_kernels(const char* instruction_set);

namespace isa_generic {
template <class T>
Kernels<T> table();
}
namespace isa_avx2 {
template <class T>
Kernels<T> table();
}
namespace isa_avx512 {
template <class T>
Kernels<T> table();
}

}  // namespace mscomp::nn
