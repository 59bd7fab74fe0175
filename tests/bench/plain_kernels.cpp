// SPDX-License-Identifier: MIT
#include "plain_kernels.h"

#include <cmath>

namespace mscomp::nn::plain {

void conv_forward(const Sizes& sizes, const Neighborhood<float>& rings, const float* x,
                  const float* mp, const float* mn, const float* bias, float* y) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int l = 0; l < sizes.lanes; ++l) {
            float mean[9] = {};
            for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
                for (int c = 0; c < 9; ++c) mean[c] += x[sizes.row(rings.neighbors[at], c, l)];
            }
            for (int o = 0; o < 9; ++o) {
                float sum = bias[o];
                for (int c = 0; c < 9; ++c) {
                    sum += mp[o * 9 + c] * x[sizes.row(v, c, l)] +
                           mn[o * 9 + c] * mean[c] * rings.inverse_degree[v];
                }
                y[sizes.row(v, o, l)] = std::tanh(sum);
            }
        }
    }
}

void conv_backward_activation(const Sizes& sizes, const float* y, const float* dy, float* dpre,
                              float* bias_grad) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const std::size_t at = sizes.row(v, c, l);
                dpre[at] = dy[at] * (1 - y[at] * y[at]);
                bias_grad[c] += dpre[at];
            }
        }
    }
}

void conv_backward(const Sizes& sizes, const Neighborhood<float>& rings, const float* x,
                   const float* dpre, const float* mp, const float* mn, float* dx, float* mp_grad,
                   float* mn_grad) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int l = 0; l < sizes.lanes; ++l) {
            float ring[9] = {};
            for (int at = rings.offsets[v]; at < rings.offsets[v + 1]; ++at) {
                const int j = rings.neighbors[at];
                for (int c = 0; c < 9; ++c) {
                    ring[c] += rings.inverse_degree[j] * dpre[sizes.row(j, c, l)];
                }
            }
            for (int c = 0; c < 9; ++c) {
                const float value = x[sizes.row(v, c, l)];
                float sum = 0;
                for (int o = 0; o < 9; ++o) {
                    const float own = dpre[sizes.row(v, o, l)];
                    sum += mp[o * 9 + c] * own + mn[o * 9 + c] * ring[o];
                    mp_grad[o * 9 + c] += own * value;
                    mn_grad[o * 9 + c] += ring[o] * value;
                }
                dx[sizes.row(v, c, l)] += sum;
            }
        }
    }
}

void project(const Sizes& sizes, const float* weights, const float* rows, float* codes) {
    for (int k = 0; k < sizes.components; ++k) {
        for (int v = 0; v < sizes.vertices; ++v) {
            for (int c = 0; c < 9; ++c) {
                for (int l = 0; l < sizes.lanes; ++l) {
                    codes[sizes.code(k, l)] +=
                        weights[sizes.weight(k, v, c)] * rows[sizes.row(v, c, l)];
                }
            }
        }
    }
}

void expand(const Sizes& sizes, const float* weights, const float* codes, float* rows) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                float sum = 0;
                for (int k = 0; k < sizes.components; ++k) {
                    sum += weights[sizes.weight(k, v, c)] * codes[sizes.code(k, l)];
                }
                rows[sizes.row(v, c, l)] = sum;
            }
        }
    }
}

void outer(const Sizes& sizes, const float* codes, const float* rows, float* weights_grad) {
    for (int k = 0; k < sizes.components; ++k) {
        for (int v = 0; v < sizes.vertices; ++v) {
            for (int c = 0; c < 9; ++c) {
                float sum = 0;
                for (int l = 0; l < sizes.lanes; ++l) {
                    sum += codes[sizes.code(k, l)] * rows[sizes.row(v, c, l)];
                }
                weights_grad[sizes.weight(k, v, c)] += sum;
            }
        }
    }
}

double squared_error(const Sizes& sizes, const float* x, const float* y, const float* lane_weight) {
    double total = 0;
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const float difference = x[sizes.row(v, c, l)] - y[sizes.row(v, c, l)];
                total += static_cast<double>(lane_weight[l] * difference * difference);
            }
        }
    }
    return total;
}

void squared_error_backward(const Sizes& sizes, const float* x, const float* y,
                            const float* lane_weight, float factor, float* dx, float* dy) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const std::size_t at = sizes.row(v, c, l);
                const float g = factor * lane_weight[l] * (x[at] - y[at]);
                dx[at] += g;
                dy[at] -= g;
            }
        }
    }
}

void masked_residual(const Sizes& sizes, const float* x, const float* y, const float* mask,
                     float* out) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const std::size_t at = sizes.row(v, c, l);
                out[at] = mask[v] * (x[at] - y[at]);
            }
        }
    }
}

void masked_residual_backward(const Sizes& sizes, const float* x, const float* y, const float* mask,
                              const float* dout, float* dx, float* dy, float* dmask) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const std::size_t at = sizes.row(v, c, l);
                dx[at] += mask[v] * dout[at];
                dy[at] -= mask[v] * dout[at];
                dmask[v] += dout[at] * (x[at] - y[at]);
            }
        }
    }
}

void tanh_forward(const float* x, std::int64_t count, float* y) {
    for (std::int64_t i = 0; i < count; ++i) y[i] = std::tanh(x[i]);
}

void adam(float* p, float* m, float* v, const float* g, std::int64_t count, float rate, float beta1,
          float beta2, float correction1, float correction2, float epsilon) {
    for (std::int64_t i = 0; i < count; ++i) {
        m[i] = beta1 * m[i] + (1 - beta1) * g[i];
        v[i] = beta2 * v[i] + (1 - beta2) * g[i] * g[i];
        p[i] -= rate * (m[i] / correction1) / (std::sqrt(v[i] / correction2) + epsilon);
    }
}

}  // namespace mscomp::nn::plain
