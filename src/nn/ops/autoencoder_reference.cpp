// SPDX-License-Identifier: MIT
// The error of a level as the formulas read.
#include <cmath>

#include "autoencoder.h"
#include "mscomp/base/index.h"

namespace mscomp::nn {

template <class T>
std::vector<T> Autoencoder<T>::reference(Tape<T>& tape) const {
    const auto mean = [&](std::int64_t v, const auto& value) {
        T sum = 0;
        for (int n = rings_.rings.offsets[at(v)]; n < rings_.rings.offsets[at(v) + 1]; ++n) {
            sum += value(rings_.rings.neighbors[at(n)]);
        }
        return sum * rings_.inverse_degree[at(v)];
    };
    std::vector<T> errors;
    for (int a = 0; a < autoencoders_; ++a) {
        const ActiveRows<T> rows = rows_of(tape, a);
        const ConvParameters<T> encoder = encoder_of(tape, a);
        const T* weights = tape.value(inputs_.component_weights).data() +
                           std::int64_t{a} * sizes_.components * vertices_ * kFeatureDim;
        const T* bias = tape.value(inputs_.decoder_bias).data() + a * kFeatureDim;
        T error = 0;
        for (int l = 0; l < lane_mask_.active; ++l) {
            const auto x = [&](std::int64_t v, int c) {
                return (rows.mask ? rows.mask[v] : T{1}) *
                       rows.source[v * row_size() + std::int64_t{c} * lanes_ + l];
            };
            std::vector<T> codes(at(sizes_.components), T{0});
            for (std::int64_t v = 0; v < vertices_; ++v) {
                for (int o = 0; o < kFeatureDim; ++o) {
                    T sum = encoder.bias[o];
                    for (int c = 0; c < kFeatureDim; ++c) {
                        sum += encoder.own[o * kFeatureDim + c] * x(v, c) +
                               encoder.ring[o * kFeatureDim + c] *
                                   mean(v, [&](std::int64_t j) { return x(j, c); });
                    }
                    for (int k = 0; k < sizes_.components; ++k) {
                        codes[at(k)] +=
                            weights[(k * vertices_ + v) * kFeatureDim + o] * std::tanh(sum);
                    }
                }
            }
            if (inputs_.latent_activation == Activation::tanh) {
                for (T& code : codes) code = std::tanh(code);
            }
            const auto expanded = [&](std::int64_t v, int c) {
                T sum = 0;
                for (int k = 0; k < sizes_.components; ++k) {
                    sum += weights[(k * vertices_ + v) * kFeatureDim + c] * codes[at(k)];
                }
                return sum;
            };
            for (std::int64_t v = 0; v < vertices_; ++v) {
                for (int o = 0; o < kFeatureDim; ++o) {
                    T sum = bias[o];
                    for (int c = 0; c < kFeatureDim; ++c) {
                        const auto i = at(o * kFeatureDim + c);
                        sum += work_[at(a)].decoder_own[i] * expanded(v, c) +
                               work_[at(a)].decoder_ring[i] *
                                   mean(v, [&](std::int64_t j) { return expanded(j, c); });
                    }
                    const T difference = x(v, o) - std::tanh(sum);
                    error += difference * difference / static_cast<T>(lane_mask_.active);
                }
            }
        }
        errors.push_back(error);
    }
    return errors;
}

template std::vector<float> Autoencoder<float>::reference(Tape<float>&) const;
template std::vector<double> Autoencoder<double>::reference(Tape<double>&) const;

}  // namespace mscomp::nn
