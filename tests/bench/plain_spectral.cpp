// SPDX-License-Identifier: MIT
#include "plain_spectral.h"

#include <algorithm>
#include <cmath>

namespace mscomp::nn::plain {

void laplacian(const Sizes& sizes, const GraphMatrix<float>& matrix, const float* x, float scale,
               const float* previous, float* out) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const std::size_t own = sizes.row(v, c, l);
                float sum = matrix.diagonal * x[own];
                for (int at = matrix.offsets[v]; at < matrix.offsets[v + 1]; ++at) {
                    sum += matrix.weights[at] * x[sizes.row(matrix.neighbors[at], c, l)];
                }
                out[own] = scale * sum - previous[own];
            }
        }
    }
}

void filter(const Sizes& sizes, const float* const* terms, int order, const float* theta,
            float* y) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int l = 0; l < sizes.lanes; ++l) {
            for (int o = 0; o < 9; ++o) {
                float sum = 0;
                for (int h = 0; h < order; ++h) {
                    for (int c = 0; c < 9; ++c) {
                        sum += terms[h][sizes.row(v, c, l)] * theta[(h * 9 + c) * 9 + o];
                    }
                }
                y[sizes.row(v, o, l)] = std::tanh(sum);
            }
        }
    }
}

void outer_9x9(const Sizes& sizes, const float* left, const float* right, float* sums) {
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int o = 0; o < 9; ++o) {
                for (int l = 0; l < sizes.lanes; ++l) {
                    sums[c * 9 + o] += left[sizes.row(v, c, l)] * right[sizes.row(v, o, l)];
                }
            }
        }
    }
}

void tanh_slope(const float* y, std::int64_t count, float* slope) {
    for (std::int64_t i = 0; i < count; ++i) slope[i] *= 1 - y[i] * y[i];
}

double error_slope(const Sizes& sizes, const float* x, const float* lane_weight, float factor,
                   float* y) {
    double total = 0;
    for (int v = 0; v < sizes.vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < sizes.lanes; ++l) {
                const std::size_t at = sizes.row(v, c, l);
                const float error = y[at] - x[at];
                total += static_cast<double>(lane_weight[l] * error * error);
                y[at] = factor * lane_weight[l] * error * (1 - y[at] * y[at]);
            }
        }
    }
    return total;
}

void lengths(const float* weights, int channels, int count, float* lengths) {
    for (int v = 0; v < count; ++v) {
        float sum = 0;
        for (int c = 0; c < channels; ++c) {
            sum += weights[v * channels + c] * weights[v * channels + c];
        }
        lengths[v] = std::sqrt(sum);
    }
}

double outside(const double* distances, const float* lengths, double range, int count) {
    double sum = 0;
    for (int v = 0; v < count; ++v) {
        if (distances[v] > range) sum += static_cast<double>(lengths[v]);
    }
    return sum;
}

void shrink(const float* moment2, const double* distances, const float* lengths, double range,
            float bound, int channels, int count, float* weights) {
    for (int v = 0; v < count; ++v) {
        if (!(distances[v] > range) || lengths[v] == 0) continue;
        float sum = 0;
        for (int c = 0; c < channels; ++c) sum += moment2[v * channels + c];
        const float kept = std::max(0.0F, 1 - std::sqrt(bound / sum) / lengths[v]);
        for (int c = 0; c < channels; ++c) weights[v * channels + c] *= kept;
    }
}

}  // namespace mscomp::nn::plain
