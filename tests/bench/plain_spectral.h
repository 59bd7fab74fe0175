// SPDX-License-Identifier: MIT
// The spectral kernels as the loops one writes first; see spectral_kernels.h for the formulas and
// plain_kernels.h for what plain means. The products of codes are those of plain_kernels.h.
#pragma once

#include "nn/kernels/spectral_kernels.h"
#include "plain_kernels.h"

namespace mscomp::nn::plain {

void laplacian(const Sizes& sizes, const GraphMatrix<float>& matrix, const float* x, float scale,
               const float* previous, float* out);
void filter(const Sizes& sizes, const float* const* terms, int order, const float* theta, float* y);
/// sums [9][9]
void outer_9x9(const Sizes& sizes, const float* left, const float* right, float* sums);
void tanh_slope(const float* y, std::int64_t count, float* slope);
double error_slope(const Sizes& sizes, const float* x, const float* lane_weight, float factor,
                   float* y);
void lengths(const float* weights, int channels, int count, float* lengths);
double outside(const double* distances, const float* lengths, double range, int count);
void shrink(const float* moment2, const double* distances, const float* lengths, double range,
            float bound, int channels, int count, float* weights);

}  // namespace mscomp::nn::plain
