// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

// The inner loops of a whole autoencoder; see ops/autoencoder.cpp for the passes that they make
// up and kernels.h for the layout. Slots number the vertices that one autoencoder touches, in
// rising order. Components and what belongs to them are packed per slot, [slot][9][padded], padded
// = components rounded up to a multiple of 8 with zeros behind them; codes are [k][lanes], and
// "across" means [lanes][padded]. Everything that is summed over slots is added to an array of the
// caller's, one per chunk of slots.
namespace mscomp::nn {

/// The slots of one autoencoder and its input x_v = mask_v source_v.
template <class T>
struct ActiveRows {
    const int* vertices;      // (slots)
    const int* ring_offsets;  // (slots+1) into ring_slots: those neighbours that have a slot
    const int* ring_slots;
    const T* inverse_degree;  // (slots) of the degree on the whole mesh
    const T* source;          // (V,9,lanes)
    const T* mask;            // (V), null: ones
    int lanes;
};

/// A convolution: W_own x + W_ring mean + bias, row-major [9][9].
template <class T>
struct ConvParameters {
    const T* own;
    const T* ring;
    const T* bias;
};

/// Sizes of the codes.
struct CodeSizes {
    int components;
    int padded;
};

/// What a child contributes to the gradient of the source that it shares with its siblings.
template <class T>
struct ChildGradient {
    const int* slot_of;   // (V), -1 where the child has no slot
    const T* input_grad;  // (slots,9,lanes)
    const T* mask;        // (V), null: ones
    T* mask_grad;         // (V), null: not wanted
    const T* constant;    // (9) output where there is no slot
    T factor;             // 2 / active lanes times the gradient of its squared error
};

template <class T>
struct AutoencoderKernels {
    /// f_s = tanh(conv x) of the slots acting[begin..end), codes += C f.
    void (*encode)(const ActiveRows<T>& rows, const ConvParameters<T>& conv, const T* components,
                   CodeSizes sizes, const int* acting, int begin, int end, T* f, T* codes);
    /// e_s = x_s - tanh(D_s codes + bias) of slots [begin, end); returns the sum of lane_weight
    /// e^2.
    double (*decode)(const ActiveRows<T>& rows, const T* decoder, const T* bias, CodeSizes sizes,
                     const T* codes, const T* lane_weight, int begin, int end, T* e);
    /// From e of decode: g_s = factor lane_weight e_s + output_grad_s (where given) and what the
    /// sum of all outputs adds for the vertex of the slot, sum_grad_v (V,9,lanes) (where given),
    /// are minus the gradient of the output; with p = -(g_s + sum_grad_v) (1 - output^2):
    /// codes_grad += D^T p, bias_grad[9] += sums of p, D_s becomes its own gradient, and g is kept
    /// where wanted (may be e itself). `scratch` holds a row.
    void (*decode_backward)(const ActiveRows<T>& rows, T* decoder, CodeSizes sizes,
                            const T* codes_across, const T* lane_weight, T factor, const T* e,
                            const T* output_grad, const T* sum_grad, int begin, int end, T* g,
                            T* codes_grad, T* bias_grad, T* scratch);
    /// f_s becomes p_s = (C^T dz)_s (1 - f_s^2) for the slots acting[begin..end); components_grad_s
    /// += f_s dz^T, bias_grad[9] += sums of p.
    void (*encode_backward)(int lanes, const T* components, CodeSizes sizes, const T* codes_grad,
                            const T* codes_grad_across, const int* acting, int begin, int end, T* f,
                            T* components_grad, T* bias_grad);
    /// With q_s = sum over the ring of p_j / deg_j: own_grad += p x^T, ring_grad += q x^T, and
    /// input_grad_s += W_own^T p + W_ring^T q where given. `scratch` holds 16 rows.
    void (*conv_backward)(const ActiveRows<T>& rows, const ConvParameters<T>& conv, const T* p,
                          int begin, int end, T* scratch, T* input_grad, T* own_grad, T* ring_grad);
    /// moments (V,10): sum of lane_weight source_v[c] for the nine channels, then that of the
    /// squares of all.
    void (*moments)(const T* source, const T* lane_weight, int lanes, int begin, int end,
                    T* moments);
    /// source_grad_v += what the children say, mask_grad likewise; vertices [begin, end).
    void (*gather_children)(const T* source, const T* moments, const T* lane_weight, int lanes,
                            const ChildGradient<T>* children, int count, int begin, int end,
                            T* source_grad);
};

}  // namespace mscomp::nn
