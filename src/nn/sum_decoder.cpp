// SPDX-License-Identifier: MIT
#include "sum_decoder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mscomp/base/index.h"
#include "nn/dim.h"

namespace mscomp::nn {
namespace {

DecoderColumn sparse(std::span<const float> rows) {
    DecoderColumn column;
    for (std::int64_t v = 0; v < static_cast<std::int64_t>(rows.size()) / kDim; ++v) {
        const std::span<const float> row = rows.subspan(at(v * kDim), at(kDim));
        if (std::ranges::all_of(row, [](float x) { return x == 0; })) continue;
        column.vertices.push_back(static_cast<int>(v));
        column.values.insert(column.values.end(), row.begin(), row.end());
    }
    return column;
}

/// column times factor (V,9), entry by entry.
void scale(DecoderColumn& column, std::span<const float> factor) {
    for (std::size_t i = 0; i < column.values.size(); ++i) {
        const std::int64_t v = column.vertices[i / at(kDim)];
        column.values[i] *= factor[at(v * kDim) + i % at(kDim)];
    }
}

/// 1 - y^2: the slope of tanh where it is y.
void to_slopes(std::vector<float>& outputs) {
    for (float& y : outputs) y = 1 - y * y;
}

}  // namespace

SumDecoder::SumDecoder(int vertices, std::vector<Part> parts)
    : vertices_(vertices), parts_(std::move(parts)) {
    for (const Part& part : parts_) code_count_ += static_cast<int>(part.columns.size());
}

/// sum_k z_k times column k, after the activation if there is one, (V,9).
std::vector<float> SumDecoder::combined(const Part& part, std::span<const float> codes) const {
    std::vector<float> sum(at(vertices_ * kDim), 0.0F);
    for (std::size_t k = 0; k < part.columns.size(); ++k) {
        const DecoderColumn& column = part.columns[k];
        if (codes[k] == 0) continue;
        for (std::size_t i = 0; i < column.values.size(); ++i) {
            const std::int64_t v = column.vertices[i / at(kDim)];
            sum[at(v * kDim) + i % at(kDim)] += codes[k] * column.values[i];
        }
    }
    if (part.map) {
        for (float& f : sum) f = std::tanh(f);
    }
    return sum;
}

std::vector<float> SumDecoder::output(const Part& part, std::vector<float> sum) const {
    if (part.map) sum = part.map(sum);
    for (std::size_t i = 0; i < sum.size(); ++i)
        sum[i] = std::tanh(sum[i] + part.bias[i % at(kDim)]);
    return sum;
}

std::vector<float> SumDecoder::decode(std::span<const float> codes, int levels) const {
    std::vector<float> total(at(vertices_ * kDim), 0.0F);
    for (const Part& part : parts_) {
        if (levels > 0 && part.level >= levels) break;
        const std::vector<float> y = output(part, combined(part, codes));
        for (std::size_t i = 0; i < y.size(); ++i) total[i] += y[i];
        codes = codes.subspan(part.columns.size());
    }
    return total;
}

std::vector<DecoderColumn> SumDecoder::derivatives(std::span<const float> codes) const {
    std::vector<DecoderColumn> all;
    for (const Part& part : parts_) {
        std::vector<float> hidden = combined(part, codes);
        std::vector<float> slopes = output(part, hidden);
        to_slopes(slopes);
        std::vector<DecoderColumn> columns = part.columns;
        if (part.map) {
            to_slopes(hidden);
            for (DecoderColumn& column : columns) {
                scale(column, hidden);
                std::vector<float> rows(at(vertices_ * kDim), 0.0F);
                for (std::size_t i = 0; i < column.values.size(); ++i) {
                    const std::int64_t v = column.vertices[i / at(kDim)];
                    rows[at(v * kDim) + i % at(kDim)] = column.values[i];
                }
                column = sparse(part.map(rows));
            }
        }
        for (DecoderColumn& column : columns) {
            scale(column, slopes);
            all.push_back(std::move(column));
        }
        codes = codes.subspan(part.columns.size());
    }
    return all;
}

template <class T>
std::vector<DecoderColumn> sparse_columns(std::span<const T> rows, int lanes, int count,
                                          const VertexOrder& order) {
    std::vector<DecoderColumn> columns(at(count));
    for (int user = 0; user < order.vertex_count(); ++user) {
        const std::int64_t v = order.to_internal[at(user)];
        for (int k = 0; k < count; ++k) {
            std::array<float, kFeatureDim> row{};
            for (std::int64_t c = 0; c < kDim; ++c) {
                row[at(c)] = static_cast<float>(rows[at((v * kDim + c) * lanes + k)]);
            }
            if (std::ranges::all_of(row, [](float x) { return x == 0; })) continue;
            columns[at(k)].vertices.push_back(user);
            columns[at(k)].values.insert(columns[at(k)].values.end(), row.begin(), row.end());
        }
    }
    return columns;
}

template std::vector<DecoderColumn> sparse_columns(std::span<const float>, int, int,
                                                   const VertexOrder&);
template std::vector<DecoderColumn> sparse_columns(std::span<const double>, int, int,
                                                   const VertexOrder&);

}  // namespace mscomp::nn
