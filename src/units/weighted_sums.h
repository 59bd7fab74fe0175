// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace mscomp {

constexpr int kTogether = 3;  // numbers of a group
constexpr int kWeights = 32;  // weights of a place

/// sums (count,kWeights) = Σ_i number_i weight_i of groups of kTogether numbers, each of them
/// (n,kTogether) place by place, and `weights` (n,kWeights). Every sum in the order of places.
void add_weighted(const double* numbers, std::size_t count, std::size_t places,
                  const double* weights, double* sums);

}  // namespace mscomp
