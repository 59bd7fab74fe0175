// SPDX-License-Identifier: MIT
// The error of the sum of all autoencoders: what is left of the shapes after a level.
#include <algorithm>

#include "autoencoder.h"
#include "batch.h"
#include "mscomp/base/index.h"

namespace mscomp::nn {

template <class T>
void Autoencoder<T>::add_up(Tape<T>& tape) {
    sum_.resize(at(source_size()));
    sum_squares_.resize(at(chunk_count(vertices_)));
    for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t chunk, int b, int e) {
        const std::int64_t first = b * row_size(), last = e * row_size();
        std::fill(sum_.begin() + first, sum_.begin() + last, T{0});
        for (int p = 0; p < parents_; ++p) {
            const T* source = tape.value(inputs_.source).data() + p * source_size();
            for (std::int64_t i = first; i < last; ++i) sum_[at(i)] += source[i];
        }
        for (int a = 0; a < autoencoders_; ++a) add_output(tape, a, T{-1}, b, e, sum_.data());
        double sum = 0;
        for (std::int64_t row = first; row < last; row += lanes_) {
            T squares = 0;
            for (int l = 0; l < lanes_; ++l) {
                const T left = sum_[at(row + l)];
                squares += lane_mask_.weight[at(l)] * left * left;
            }
            sum += static_cast<double>(squares);
        }
        sum_squares_[at(chunk)] = sum;
    });
    double error = 0;
    for (const double of_chunk : sum_squares_) error += of_chunk;
    tape.value(outputs_.sum_error)[0] = static_cast<T>(error / lane_mask_.active);
}

template <class T>
void Autoencoder<T>::sum_to_gradient(Tape<T>& tape) {
    const T factor_of_sum = factor(tape.grad(outputs_.sum_error)[0]);
    sum_grads_.resize(has_constant_rest_ ? at(vertices_) : 0);
    for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int b, int e) {
        for (std::int64_t row = b * kFeatureDim; row < std::int64_t{e} * kFeatureDim; ++row) {
            T* values = sum_.data() + row * lanes_;
            T sum = 0;
            for (int l = 0; l < lanes_; ++l) {
                values[l] *= factor_of_sum * lane_mask_.weight[at(l)];
                sum += values[l];
            }
            if (!has_constant_rest_) continue;
            sum_grads_[at(row / kFeatureDim)][at(row % kFeatureDim)] = static_cast<double>(sum);
        }
    });
}

template <class T>
void Autoencoder<T>::add_sum_to_sources(Tape<T>& tape) {
    T* grads = tape.grad(inputs_.source).data();
    for_each_chunk(parents_, vertices_, [&](std::int64_t p, std::int64_t, int b, int e) {
        T* grad = grads + p * source_size();
        for (std::int64_t i = b * row_size(); i < e * row_size(); ++i) grad[i] += sum_[at(i)];
    });
}

template void Autoencoder<float>::add_up(Tape<float>&);
template void Autoencoder<double>::add_up(Tape<double>&);
template void Autoencoder<float>::sum_to_gradient(Tape<float>&);
template void Autoencoder<double>::sum_to_gradient(Tape<double>&);
template void Autoencoder<float>::add_sum_to_sources(Tape<float>&);
template void Autoencoder<double>::add_sum_to_sources(Tape<double>&);

}  // namespace mscomp::nn
