// SPDX-License-Identifier: MIT
// The kernels as the loops one writes first: one shape of one vertex at a time, in the order of the
// formulas of kernels.h, compiled like the rest of the program. What the fast ones are checked
// against and compared with. All vertices of an array rather than a part of them.
#pragma once

#include <cstdint>
#include <vector>

#include "nn/kernels/kernels.h"

namespace mscomp::nn::plain {

/// Sizes of the arrays: rows (vertices,9,lanes), component weights (components,vertices,9).
struct Sizes {
    int vertices, lanes, components;

    std::size_t row(int vertex, int channel, int lane) const {
        return (static_cast<std::size_t>(vertex) * 9 + static_cast<std::size_t>(channel)) *
                   static_cast<std::size_t>(lanes) +
               static_cast<std::size_t>(lane);
    }
    std::size_t weight(int component, int vertex, int channel) const {
        return (static_cast<std::size_t>(component) * static_cast<std::size_t>(vertices) +
                static_cast<std::size_t>(vertex)) *
                   9 +
               static_cast<std::size_t>(channel);
    }
    std::size_t code(int component, int lane) const {
        return static_cast<std::size_t>(component) * static_cast<std::size_t>(lanes) +
               static_cast<std::size_t>(lane);
    }
};

void conv_forward(const Sizes& sizes, const Neighborhood<float>& rings, const float* x,
                  const float* mp, const float* mn, const float* bias, float* y);
void conv_backward_activation(const Sizes& sizes, const float* y, const float* dy, float* dpre,
                              float* bias_grad);
void conv_backward(const Sizes& sizes, const Neighborhood<float>& rings, const float* x,
                   const float* dpre, const float* mp, const float* mn, float* dx, float* mp_grad,
                   float* mn_grad);
void project(const Sizes& sizes, const float* weights, const float* rows, float* codes);
void expand(const Sizes& sizes, const float* weights, const float* codes, float* rows);
void outer(const Sizes& sizes, const float* codes, const float* rows, float* weights_grad);
double squared_error(const Sizes& sizes, const float* x, const float* y, const float* lane_weight);
void squared_error_backward(const Sizes& sizes, const float* x, const float* y,
                            const float* lane_weight, float factor, float* dx, float* dy);
void masked_residual(const Sizes& sizes, const float* x, const float* y, const float* mask,
                     float* out);
void masked_residual_backward(const Sizes& sizes, const float* x, const float* y, const float* mask,
                              const float* dout, float* dx, float* dy, float* dmask);
void tanh_forward(const float* x, std::int64_t count, float* y);
void adam(float* p, float* m, float* v, const float* g, std::int64_t count, float rate, float beta1,
          float beta2, float correction1, float correction2, float epsilon);

}  // namespace mscomp::nn::plain
