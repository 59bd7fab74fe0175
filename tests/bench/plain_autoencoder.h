// SPDX-License-Identifier: MIT
// The kernels of a whole autoencoder as the loops one writes first; see autoencoder_kernels.h for
// the formulas and plain_kernels.h for what plain means. All slots act.
#pragma once

#include "nn/kernels/autoencoder_kernels.h"

namespace mscomp::nn::plain {

void encode(const ActiveRows<float>& rows, const ConvParameters<float>& conv,
            const float* components, CodeSizes sizes, int slots, float* f, float* codes);
double decode(const ActiveRows<float>& rows, const float* decoder, const float* bias,
              CodeSizes sizes, const float* codes, const float* lane_weight, int slots, float* e);
void decode_backward(const ActiveRows<float>& rows, float* decoder, CodeSizes sizes,
                     const float* codes_across, const float* lane_weight, float factor,
                     const float* e, int slots, float* g, float* codes_grad, float* bias_grad);
void encode_backward(int lanes, const float* components, CodeSizes sizes, const float* codes_grad,
                     int slots, float* f, float* components_grad, float* bias_grad);
void conv_backward(const ActiveRows<float>& rows, const ConvParameters<float>& conv, const float* p,
                   int slots, float* input_grad, float* own_grad, float* ring_grad);
void moments(const float* source, const float* lane_weight, int lanes, int vertices,
             float* moments);
void gather_children(const float* source, const float* moments, const float* lane_weight, int lanes,
                     const ChildGradient<float>* children, int count, int vertices,
                     float* source_grad);

}  // namespace mscomp::nn::plain
