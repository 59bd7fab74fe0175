// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "nn/code_decoder.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {

/// Levels come one after the other.
/// X_i = sum over autoencoders a of tanh(bias_a + D_a,i) where D_a = M_a(sum_k z_ak C_ak), M_a the
/// linear part of a decoder's convolution; or with an activation in between, M_a(tanh(sum ...)).
/// Linear decoders are kept as the columns M_a(C_ak), which are as sparse as the components.
class SumDecoder final : public CodeDecoder {
  public:
    /// Rows (V,9) in the order of the user -> their image under M_a.
    using RowMap = std::function<std::vector<float>(const std::vector<float>& rows)>;

    struct Part {
        int level = 0;
        std::array<float, kFeatureDim> bias{};
        std::vector<DecoderColumn> columns;  // M_a(C_ak), or C_ak where there is a map
        RowMap map;                          // only with an activation in between
    };

    SumDecoder(int vertices, std::vector<Part> parts);

    int code_count() const override { return code_count_; }
    int vertex_count() const override { return vertices_; }
    std::vector<float> decode(std::span<const float> codes, int levels = 0) const override;
    std::vector<DecoderColumn> derivatives(std::span<const float> codes) const override;

  private:
    std::vector<float> combined(const Part& part, std::span<const float> codes) const;
    std::vector<float> output(const Part& part, std::vector<float> sum) const;

    int vertices_;
    int code_count_ = 0;
    std::vector<Part> parts_;
};

/// The first `count` columns of rows (V,9,lanes) in inner vertex order, without the vertices where
/// they are zero.
template <class T>
std::vector<DecoderColumn> sparse_columns(std::span<const T> rows, int lanes, int count,
                                          const VertexOrder& order);

}  // namespace mscomp::nn
