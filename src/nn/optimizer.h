// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include "mscomp/nn/config.h"
#include "nn/parameter_set.h"

namespace mscomp::nn {

/// Staircase decay: learning_rate * decay^floor((step - 1) / decay_steps), not below the floor;
/// steps count from 1.
double learning_rate_at(const TrainConfig& config, std::int64_t step);

/// 1 - beta2^step: Adam's second moments are divided by it, since they start from zero.
double second_moment_correction(std::int64_t step);

/// The first parameter with a number that is not finite where it is live, -1 if there is none;
/// `all` are the values, gradients or moments of all parameters.
template <class T>
int first_non_finite(const ParameterSet<T>& parameters, std::span<const T> all);

/// One Adam update (Kingma & Ba 2015; beta 0.9, 0.999, epsilon 1e-8) of all parameters from their
/// gradients, `rate` times the rate scale of each; `step` counts from 1.
template <class T>
void adam_step(ParameterSet<T>& parameters, double rate, std::int64_t step);

}  // namespace mscomp::nn
