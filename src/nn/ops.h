// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "base/aligned.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/config.h"
#include "nn/sparsity_rows.h"
#include "nn/tape.h"

// The ops of the stacked autoencoders. A level is a batch of A autoencoders, so every tensor starts
// with A: rows (A,V,9,lanes), codes (A,K,lanes), component weights (A,K,V,9), convolution matrices
// (A,9,9), biases (A,9), per-autoencoder scalars (A). Lanes are the shapes of the batch padded to a
// multiple of 8 (16 above 8); LaneMask says which count.
namespace mscomp::nn {

/// Lanes for `shapes` shapes.
int lane_count(int shapes);

/// Which lanes hold a shape: weight 1, the others 0.
template <class T>
struct LaneMask {
    int active = 0;
    AlignedVector<T> weight;  // (lanes)
};

/// One-rings with what the convolution needs per vertex; borrowed by the ops.
template <class T>
struct RingTable {
    explicit RingTable(OneRings one_rings);
    OneRings rings;
    std::vector<T> inverse_degree;  // (V), 0 for isolated vertices
    int vertex_count() const { return rings.vertex_count(); }
};

/// y_i = act(M_p x_i + M_n mean_{N(i)} x_j + b), M = W or W^T where `transposed`. [A] eq. 1.
template <class T>
Var mesh_conv(Tape<T>& tape, const RingTable<T>& rings, Var x, Var w_own, Var w_ring, Var bias,
              bool transposed, Activation activation);

/// z_k = sum_i <C_k,i, f_i>: rows (A,V,9,L), C (A,K,V,9) -> codes (A,K,L).
template <class T>
Var project(Tape<T>& tape, Var rows, Var component_weights);

/// f_i = sum_k C_k,i z_k: codes (A,K,L), C -> rows (A,V,9,L).
template <class T>
Var expand(Tape<T>& tape, Var codes, Var component_weights);

/// tanh of every element.
template <class T>
Var tanh(Tape<T>& tape, Var x);

/// Masks (A*K,V) of the children from C (A,K,V,9), columns summing to 1 over the K of one
/// autoencoder: AM_k = (q_k^p + e)/(sum_k q_k^p + K e), q_k = (a_k + e)/(sum_k a_k + K e),
/// a_ki = |C_k,i|^2; for p = 1 AM = q, [A] eq. 5 and 6.
template <class T>
Var attention_mask(Tape<T>& tape, Var component_weights, double power, double epsilon);

/// Inputs of the children, mask_k,i (x - y)_i: (A,V,9,L), mask (A*K,V) -> (A*K,V,9,L); without a
/// valid mask one child per parent sees x - y. `joint` false stops the gradients.
template <class T>
Var masked_residual(Tape<T>& tape, Var x, Var y, Var mask, bool joint);

/// The sum over all autoencoders of all `rows`, each (A,V,9,L): (1,V,9,L). `joint` false stops the
/// gradients of all but the last.
template <class T>
Var sum_rows(Tape<T>& tape, std::vector<Var> rows, bool joint);

/// (1/active lanes) sum over vertices, channels and active lanes of (x - y)^2 per autoencoder: (A).
template <class T>
Var squared_error(Tape<T>& tape, Var x, Var y, const LaneMask<T>& lanes);

/// Omega = (1/K) sum_k sum_i Lambda_ik |C_k,i| per autoencoder: (A). The centres that Lambda is
/// counted from are brought up to date first (SparsityRows::focus) and constant for
/// differentiation; the gradient of |x| at 0 is 0. `differentiable` false reports the value only
/// (the proximal step then does the rest). `sparsity` is borrowed.
template <class T>
Var group_sparsity(Tape<T>& tape, Var component_weights, SparsityRows& sparsity,
                   bool differentiable);

/// (1/K) sum_k max(max_m |z_km| - limit, 0) over active lanes per autoencoder: (A); the gradient
/// goes to the first shape that reaches the maximum.
template <class T>
Var range_penalty(Tape<T>& tape, Var codes, double limit, const LaneMask<T>& lanes);

/// sum_j factor_j sum(terms_j): a single number.
template <class T>
Var weighted_sum(Tape<T>& tape, std::vector<Var> terms, std::vector<double> factors);

}  // namespace mscomp::nn
