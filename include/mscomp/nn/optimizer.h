// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "mscomp/nn/config.h"
#include "mscomp/nn/parameter_set.h"
#include "mscomp/nn/stacked_model.h"

namespace mscomp::nn {

/// Staircase decay: learning_rate * decay^floor((step - 1) / decay_steps), not below the floor;
/// steps count from 1.
double learning_rate_at(const TrainConfig& config, std::int64_t step);

/// 1 - beta2^step: Adam's second moments are divided by it, since they start from zero.
double second_moment_correction(std::int64_t step);

/// The first parameter with a gradient that is not finite, -1 if there is none.
template <class T>
int first_non_finite_grad(const ParameterSet<T>& parameters);

/// One Adam update (Kingma & Ba 2015; beta 0.9, 0.999, epsilon 1e-8) of all parameters from their
/// gradients, `rate` times the rate scale of each; `step` counts from 1.
template <class T>
void adam_step(ParameterSet<T>& parameters, double rate, std::int64_t step);

/// The proximal step of group sparsity in Adam's metric, to be taken after adam_step:
/// C_k,i <- C_k,i max(0, 1 - rate w Lambda_ik / (K sqrt(v) |C_k,i|)), w = sparsity weight, v =
/// Adam's bias-corrected second moment averaged over the nine channels (method §7). Leaves exact
/// zeros.
template <class T>
void proximal_step(StackedModel<T>& model, double sparsity_weight, double rate, std::int64_t step);

}  // namespace mscomp::nn
