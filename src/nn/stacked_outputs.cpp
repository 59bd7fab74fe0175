// SPDX-License-Identifier: MIT
// What a pass left, in the order and numbering of the user, and decoding of single codes.
#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "mscomp/nn/stacked_model.h"
#include "ops/autoencoder.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kDim = kFeatureDim;

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

}  // namespace

template <class T>
std::vector<T> StackedModel<T>::codes(int level) {
    const Level& l = levels_[at(level)];
    const std::span<T> code = tape_.value(l.code);
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    std::vector<T> result;
    for (int m = 0; m < lane_mask_.active; ++m) {
        for (std::int64_t k = 0; k < std::int64_t{l.autoencoders} * l.components; ++k) {
            result.push_back(code[at(k * lanes + m)]);
        }
    }
    return result;
}

template <class T>
std::vector<T> StackedModel<T>::batch_rows(std::span<const T> rows) const {
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    const std::int64_t size = vertex_count() * kDim;
    std::vector<T> result(at(size * lane_mask_.active));
    for (std::int64_t v = 0; v < vertex_count(); ++v) {
        for (std::int64_t c = 0; c < kDim; ++c) {
            for (std::int64_t m = 0; m < lane_mask_.active; ++m) {
                result[at(m * size + order_.to_user[at(v)] * kDim + c)] =
                    rows[at((v * kDim + c) * lanes + m)];
            }
        }
    }
    return result;
}

template <class T>
void StackedModel<T>::input_rows(int level, int autoencoder, std::span<T> rows) {
    const Level& l = levels_[at(level)];
    const std::int64_t size = static_cast<std::int64_t>(rows.size());
    if (!l.source.valid()) {
        std::copy_n(tape_.value(l.x).begin() + autoencoder * size, size, rows.begin());
        return;
    }
    const std::int64_t parent = autoencoder / (l.autoencoders / tape_.extents(l.source)[0]);
    const T* source = tape_.value(l.source).data() + parent * size;
    const T* mask = l.source_mask.valid()
                        ? tape_.value(l.source_mask).data() + autoencoder * vertex_count()
                        : nullptr;
    const std::int64_t row = size / vertex_count();
    parallel_for(vertex_count(), [&](std::int64_t v) {
        for (std::int64_t i = v * row; i < (v + 1) * row; ++i) {
            rows[at(i)] = mask ? mask[v] * source[i] : source[i];
        }
    });
}

template <class T>
std::vector<T> StackedModel<T>::reconstruction(int levels) {
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    const std::int64_t rows = vertex_count() * kDim * lanes;
    AlignedVector<T> sum(at(rows), T{0});
    for (int l = 0; l < levels; ++l) {
        for (int a = 0; a < levels_[at(l)].autoencoders; ++a) {
            if (!fused_.empty()) {
                fused_[at(l)]->add_output(tape_, a, sum);
                continue;
            }
            const std::span<T> output = tape_.value(levels_[at(l)].output);
            for (std::int64_t i = 0; i < rows; ++i) sum[at(i)] += output[at(a * rows + i)];
        }
    }
    return batch_rows(sum);
}

template <class T>
std::vector<T> StackedModel<T>::input_gradient() {
    return batch_rows(tape_.grad(levels_.front().x));
}

template <class T>
std::vector<T> StackedModel<T>::decode(int level, int autoencoder, std::span<const T> code) {
    // A tape of its own with one autoencoder of eight lanes, all holding the same code.
    const Level& l = levels_[at(level)];
    ParameterSet<T> own;
    const auto copy = [&](int index) {
        Extents extents = parameters_.entry(index).extents;
        const std::span<const T> all = parameters_.value(index);
        const std::size_t size = all.size() / at(extents[0]);
        extents[0] = 1;
        const int made = own.add(parameters_.entry(index).name, std::move(extents));
        const std::span<const T> slice = all.subspan(at(autoencoder) * size, size);
        std::copy(slice.begin(), slice.end(), own.value(made).begin());
        return made;
    };
    const int w_own = copy(l.decoder_w_own), w_ring = copy(l.decoder_w_ring);
    const int bias = copy(l.decoder_bias), weights = copy(l.weights);

    Tape<T> tape;
    const int lanes = lane_count(1);
    const Var codes = tape.input("code", {1, l.components, lanes});
    for (int k = 0; k < l.components; ++k) {
        std::fill_n(tape.value(codes).begin() + k * lanes, lanes, code[at(k)]);
    }
    Var decoded = expand(tape, codes, tape.parameter(own, weights));
    if (config_.decoder_fc_activation == Activation::tanh) decoded = tanh(tape, decoded);
    const Var output =
        mesh_conv(tape, rings_, decoded, tape.parameter(own, w_own), tape.parameter(own, w_ring),
                  tape.parameter(own, bias), config_.tied == Tied::transpose, Activation::tanh);
    tape.forward();
    std::vector<T> result(at(vertex_count() * kDim));
    for (std::int64_t v = 0; v < vertex_count(); ++v) {
        for (std::int64_t c = 0; c < kDim; ++c) {
            result[at(order_.to_user[at(v)] * kDim + c)] =
                tape.value(output)[at((v * kDim + c) * lanes)];
        }
    }
    return result;
}

template std::vector<float> StackedModel<float>::codes(int);
template std::vector<float> StackedModel<float>::batch_rows(std::span<const float>) const;
template void StackedModel<float>::input_rows(int, int, std::span<float>);
template std::vector<float> StackedModel<float>::reconstruction(int);
template std::vector<float> StackedModel<float>::input_gradient();
template std::vector<float> StackedModel<float>::decode(int, int, std::span<const float>);
template std::vector<double> StackedModel<double>::codes(int);
template std::vector<double> StackedModel<double>::batch_rows(std::span<const double>) const;
template void StackedModel<double>::input_rows(int, int, std::span<double>);
template std::vector<double> StackedModel<double>::reconstruction(int);
template std::vector<double> StackedModel<double>::input_gradient();
template std::vector<double> StackedModel<double>::decode(int, int, std::span<const double>);

}  // namespace mscomp::nn
