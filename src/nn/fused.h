// SPDX-License-Identifier: MIT
#pragma once

#include "nn/active_vertices.h"
#include "nn/ops.h"

namespace mscomp::nn {

/// What a level of A autoencoders is made of; see ops.h for the shapes.
struct AutoencoderInputs {
    Var source;  // (P,V,9,lanes): the data or the residuals of P parents, A a multiple of P
    Var mask;    // (A,V), or not valid: ones
    Var w_own, w_ring, bias;                          // of the encoder
    Var decoder_w_own, decoder_w_ring, decoder_bias;  // may be those of the encoder
    Var component_weights;                            // C (A,K,V,9)
    bool transposed_decoder = true;                   // the decoder applies W^T
    Activation latent_activation = Activation::none;
    bool joint = true;  // false: no gradient for source and mask
    bool keeps_residual = false;
    bool keeps_sum_error = false;
    double error_weight = 1;  // what the gradient of the error will be, see expect_backward
};

struct AutoencoderOutputs {
    Var code;      // (A,K,lanes)
    Var error;     // (A), squared_error of input and output
    Var residual;  // (A,V,9,lanes) input minus output; not valid unless kept
    /// (1), (1/active lanes) sum of the squares of sum_p source_p - sum_a output_a: what is left of
    /// the shapes after all levels up to this one, since masks of siblings sum to 1. Not valid
    /// unless kept.
    Var sum_error;
};

/// A whole level as one op, equal to
///   x = mask (source), f = mesh_conv tanh, code = project, expand, y = mesh_conv tanh,
///   squared_error(x, y), residual = x - y, squared_error(sum_rows(source), sum_rows(y))
/// of ops.h. Since nothing happens between expand and the convolution of the decoder, that
/// convolution is applied to the K component weights instead of the shapes,
///   D_k,i = W_own' C_k,i + W_ring' mean_{N(i)} C_k,j,   y_i = tanh(sum_k D_k,i z_k + b'),
/// so that the decoder works on each vertex alone; and what lies outside the active vertices, where
/// y is tanh(b'), has a closed form in ten moments per vertex of the source. Exact as long as C is
/// zero wherever `supports` does not act; the gradient of C is left out there. A level that keeps
/// its residual acts everywhere. One backward per forward: it uses up what forward left.
///
/// `rings`, `lane_mask` and `supports` are borrowed.
template <class T>
AutoencoderOutputs autoencoder(Tape<T>& tape, const RingTable<T>& rings,
                               const AutoencoderInputs& inputs, const LaneMask<T>& lane_mask,
                               const LevelSupports& supports);

}  // namespace mscomp::nn
