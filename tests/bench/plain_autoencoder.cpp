// SPDX-License-Identifier: MIT
#include "plain_autoencoder.h"

#include <cmath>
#include <cstddef>

namespace mscomp::nn::plain {
namespace {

/// Place of a channel of a slot or vertex, in numbers of `width` each.
std::size_t place(int slot, int channel, int width) {
    return (static_cast<std::size_t>(slot) * 9 + static_cast<std::size_t>(channel)) *
           static_cast<std::size_t>(width);
}

float input(const ActiveRows<float>& rows, int slot, int channel, int lane) {
    const int vertex = rows.vertices[slot];
    return rows.mask[vertex] *
           rows.source[place(vertex, channel, rows.lanes) + static_cast<std::size_t>(lane)];
}

}  // namespace

void encode(const ActiveRows<float>& rows, const ConvParameters<float>& conv,
            const float* components, CodeSizes sizes, int slots, float* f, float* codes) {
    const int lanes = rows.lanes;
    for (int s = 0; s < slots; ++s) {
        for (int l = 0; l < lanes; ++l) {
            float mean[9] = {};
            for (int at = rows.ring_offsets[s]; at < rows.ring_offsets[s + 1]; ++at) {
                for (int c = 0; c < 9; ++c) mean[c] += input(rows, rows.ring_slots[at], c, l);
            }
            for (int o = 0; o < 9; ++o) {
                float sum = conv.bias[o];
                for (int c = 0; c < 9; ++c) {
                    sum += conv.own[o * 9 + c] * input(rows, s, c, l) +
                           conv.ring[o * 9 + c] * mean[c] * rows.inverse_degree[s];
                }
                const float out = std::tanh(sum);
                f[place(s, o, lanes) + static_cast<std::size_t>(l)] = out;
                for (int k = 0; k < sizes.components; ++k) {
                    codes[k * lanes + l] +=
                        components[place(s, o, sizes.padded) + static_cast<std::size_t>(k)] * out;
                }
            }
        }
    }
}

double decode(const ActiveRows<float>& rows, const float* decoder, const float* bias,
              CodeSizes sizes, const float* codes, const float* lane_weight, int slots, float* e) {
    double total = 0;
    for (int s = 0; s < slots; ++s) {
        for (int c = 0; c < 9; ++c) {
            const float* matrix = decoder + place(s, c, sizes.padded);
            for (int l = 0; l < rows.lanes; ++l) {
                float sum = bias[c];
                for (int k = 0; k < sizes.components; ++k) {
                    sum += matrix[k] * codes[k * rows.lanes + l];
                }
                const float difference = input(rows, s, c, l) - std::tanh(sum);
                e[place(s, c, rows.lanes) + static_cast<std::size_t>(l)] = difference;
                total += static_cast<double>(lane_weight[l] * difference * difference);
            }
        }
    }
    return total;
}

void decode_backward(const ActiveRows<float>& rows, float* decoder, CodeSizes sizes,
                     const float* codes_across, const float* lane_weight, float factor,
                     const float* e, int slots, float* g, float* codes_grad, float* bias_grad) {
    const int lanes = rows.lanes;
    for (int s = 0; s < slots; ++s) {
        for (int c = 0; c < 9; ++c) {
            float* matrix = decoder + place(s, c, sizes.padded);
            float slope[64] = {};
            for (int l = 0; l < lanes; ++l) {
                const std::size_t at = place(s, c, lanes) + static_cast<std::size_t>(l);
                const float output = input(rows, s, c, l) - e[at];
                g[at] = factor * lane_weight[l] * e[at];
                slope[l] = -g[at] * (1 - output * output);
                bias_grad[c] += slope[l];
            }
            for (int k = 0; k < sizes.components; ++k) {
                float sum = 0;
                for (int l = 0; l < lanes; ++l) {
                    codes_grad[k * lanes + l] += matrix[k] * slope[l];
                    sum += slope[l] * codes_across[l * sizes.padded + k];
                }
                matrix[k] = sum;
            }
        }
    }
}

void encode_backward(int lanes, const float* components, CodeSizes sizes, const float* codes_grad,
                     int slots, float* f, float* components_grad, float* bias_grad) {
    for (int s = 0; s < slots; ++s) {
        for (int c = 0; c < 9; ++c) {
            const float* matrix = components + place(s, c, sizes.padded);
            float* matrix_grad = components_grad + place(s, c, sizes.padded);
            for (int l = 0; l < lanes; ++l) {
                float& out = f[place(s, c, lanes) + static_cast<std::size_t>(l)];
                float sum = 0;
                for (int k = 0; k < sizes.components; ++k) {
                    matrix_grad[k] += out * codes_grad[k * lanes + l];
                    sum += matrix[k] * codes_grad[k * lanes + l];
                }
                out = sum * (1 - out * out);
                bias_grad[c] += out;
            }
        }
    }
}

void conv_backward(const ActiveRows<float>& rows, const ConvParameters<float>& conv, const float* p,
                   int slots, float* input_grad, float* own_grad, float* ring_grad) {
    const int lanes = rows.lanes;
    const auto at = [lanes](int s, int c, int l) {
        return place(s, c, lanes) + static_cast<std::size_t>(l);
    };
    for (int s = 0; s < slots; ++s) {
        for (int l = 0; l < lanes; ++l) {
            float ring[9] = {};
            for (int n = rows.ring_offsets[s]; n < rows.ring_offsets[s + 1]; ++n) {
                const int j = rows.ring_slots[n];
                for (int c = 0; c < 9; ++c) ring[c] += rows.inverse_degree[j] * p[at(j, c, l)];
            }
            for (int c = 0; c < 9; ++c) {
                const float value = input(rows, s, c, l);
                float sum = 0;
                for (int o = 0; o < 9; ++o) {
                    const float own = p[at(s, o, l)];
                    sum += conv.own[o * 9 + c] * own + conv.ring[o * 9 + c] * ring[o];
                    own_grad[o * 9 + c] += own * value;
                    ring_grad[o * 9 + c] += ring[o] * value;
                }
                input_grad[at(s, c, l)] += sum;
            }
        }
    }
}

void moments(const float* source, const float* lane_weight, int lanes, int vertices,
             float* moments) {
    for (int v = 0; v < vertices; ++v) {
        float* out = moments + static_cast<std::size_t>(v) * 10;
        for (int i = 0; i < 10; ++i) out[i] = 0;
        for (int c = 0; c < 9; ++c) {
            const float* row = source + place(v, c, lanes);
            for (int l = 0; l < lanes; ++l) {
                out[c] += lane_weight[l] * row[l];
                out[9] += lane_weight[l] * row[l] * row[l];
            }
        }
    }
}

void gather_children(const float* source, const float* moments, const float* lane_weight, int lanes,
                     const ChildGradient<float>* children, int count, int vertices,
                     float* source_grad) {
    for (int v = 0; v < vertices; ++v) {
        for (int k = 0; k < count; ++k) {
            const ChildGradient<float>& child = children[k];
            const float mask = child.mask[v];
            const int slot = child.slot_of[v];
            const float* moment = moments + static_cast<std::size_t>(v) * 10;
            if (slot < 0) child.mask_grad[v] += child.factor * mask * moment[9];
            for (int c = 0; c < 9; ++c) {
                if (slot < 0) child.mask_grad[v] -= child.factor * child.constant[c] * moment[c];
                for (int l = 0; l < lanes; ++l) {
                    const std::size_t at = place(v, c, lanes) + static_cast<std::size_t>(l);
                    if (slot < 0) {
                        source_grad[at] += child.factor * lane_weight[l] * mask *
                                           (mask * source[at] - child.constant[c]);
                    } else {
                        const float g =
                            child.input_grad[place(slot, c, lanes) + static_cast<std::size_t>(l)];
                        source_grad[at] += mask * g;
                        child.mask_grad[v] += g * source[at];
                    }
                }
            }
        }
    }
}

}  // namespace mscomp::nn::plain
