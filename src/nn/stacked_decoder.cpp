// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/dim.h"
#include "nn/stacked_model.h"
#include "sum_decoder.h"

namespace mscomp::nn {
namespace {

/// The linear part of a decoder's convolution for one autoencoder, on its own.
template <class T>
struct DecoderConvolution {
    OneRings rings;
    std::vector<T> w_own, w_ring;  // (9,9)
    bool transposed;

    /// Rows (V,9,lanes) -> rows.
    std::vector<T> operator()(std::span<const T> rows, std::int64_t lanes) const {
        ParameterSet<T> own;
        const int own_index = own.add("w_own", {1, kDim, kDim});
        const int ring_index = own.add("w_ring", {1, kDim, kDim});
        const int bias_index = own.add("bias", {1, kDim});
        std::ranges::copy(w_own, own.value(own_index).begin());
        std::ranges::copy(w_ring, own.value(ring_index).begin());
        const RingTable<T> table(rings);
        Tape<T> tape;
        const Var x = tape.input("rows", {1, table.vertex_count(), kDim, lanes});
        std::ranges::copy(rows, tape.value(x).begin());
        const Var y = mesh_conv(tape, table, x, tape.parameter(own, own_index),
                                tape.parameter(own, ring_index), tape.parameter(own, bias_index),
                                transposed, Activation::none);
        tape.forward();
        return {tape.value(y).begin(), tape.value(y).end()};
    }
};

template <class T>
std::span<const T> slice_of(std::span<const T> all, std::int64_t count, std::int64_t index) {
    const std::size_t size = all.size() / at(count);
    return all.subspan(at(index) * size, size);
}

/// Component weights (K,V,9) as rows (V,9,lanes), components [first, first + count) in the lanes.
template <class T>
std::vector<T> in_lanes(std::span<const T> weights, std::int64_t vertices, int first, int count,
                        int lanes) {
    const std::int64_t size = vertices * kDim;
    std::vector<T> rows(at(size * lanes), T{0});
    for (std::int64_t k = 0; k < count; ++k) {
        for (std::int64_t i = 0; i < size; ++i) {
            rows[at(i * lanes + k)] = weights[at((first + k) * size + i)];
        }
    }
    return rows;
}

template <class T>
SumDecoder::Part part_of(const StackedModel<T>& model, const OneRings& rings, int level_index,
                         int a) {
    const StackedConfig& config = model.config();
    const auto& level = model.levels()[at(level_index)];
    const auto slice = [&](int index) {
        return slice_of(model.parameters().value(index), level.autoencoders, a);
    };
    const auto copy = [&](int index) {
        const std::span<const T> values = slice(index);
        return std::vector<T>(values.begin(), values.end());
    };
    const DecoderConvolution<T> convolution{rings, copy(level.decoder_w_own),
                                            copy(level.decoder_w_ring),
                                            config.tied == Tied::transpose};
    SumDecoder::Part part;
    part.level = level_index;
    std::ranges::transform(slice(level.decoder_bias), part.bias.begin(),
                           [](T b) { return static_cast<float>(b); });
    const bool is_linear = config.decoder_fc_activation == Activation::none;
    const int lanes = lane_count(1);
    for (int first = 0; first < level.components; first += lanes) {
        const int count = std::min(lanes, level.components - first);
        std::vector<T> rows =
            in_lanes(slice(level.weights), model.vertex_count(), first, count, lanes);
        if (is_linear) rows = convolution(rows, lanes);
        for (DecoderColumn& column :
             sparse_columns(std::span<const T>(rows), lanes, count, model.order())) {
            part.columns.push_back(std::move(column));
        }
    }
    if (!is_linear) {
        part.map = [convolution, lanes, order = model.order()](const std::vector<float>& user) {
            std::vector<T> rows(user.size() * at(lanes), T{0});
            for (std::size_t i = 0; i < user.size(); ++i) {
                const std::int64_t v = order.to_internal[i / at(kDim)];
                rows[(at(v * kDim) + i % at(kDim)) * at(lanes)] = static_cast<T>(user[i]);
            }
            rows = convolution(rows, lanes);
            std::vector<float> image(user.size());
            for (std::size_t i = 0; i < user.size(); ++i) {
                const std::int64_t v = order.to_internal[i / at(kDim)];
                image[i] = static_cast<float>(rows[(at(v * kDim) + i % at(kDim)) * at(lanes)]);
            }
            return image;
        };
    }
    return part;
}

}  // namespace

template <class T>
std::unique_ptr<CodeDecoder> StackedModel<T>::decoder() const {
    std::vector<SumDecoder::Part> parts;
    for (int l = 0; l < static_cast<int>(levels_.size()); ++l) {
        for (int a = 0; a < levels_[at(l)].autoencoders; ++a) {
            parts.push_back(part_of(*this, rings_.rings, l, a));
        }
    }
    return std::make_unique<SumDecoder>(this->vertex_count(), std::move(parts));
}

template std::unique_ptr<CodeDecoder> StackedModel<float>::decoder() const;
template std::unique_ptr<CodeDecoder> StackedModel<double>::decoder() const;

}  // namespace mscomp::nn
