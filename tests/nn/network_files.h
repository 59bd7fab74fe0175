// SPDX-License-Identifier: MIT
// Networks to and from model files, for tests that hold a bare one.
#pragma once

#include <string>
#include <vector>

#include "mscomp/model/model_file.h"
#include "nn/network.h"

namespace mscomp::nn {

inline void write_network(const std::string& path, Model<float>& model, const ModelContext& context,
                          const TrainingState& state, const CodeTable& codes) {
    write_model(path, Network(model, context.scale), context, state, codes);
}

inline void load_network(const ModelFile& file, Model<float>& model) {
    Network network(model, file.context().scale);
    file.load(network);
}

/// Features times `factor` around the reference, which is zero then.
inline MetricScale around_reference(double factor) {
    MetricScale scale;
    scale.factor.fill(factor);
    for (std::size_t c = 0; c < kFeatureDim; ++c) {
        scale.offset[c] = static_cast<double>(kReferenceFeature[c]);
    }
    return scale;
}

/// Codes (n,K) of levels side by side.
inline CodeTable joined_codes(const std::vector<std::vector<float>>& levels, int shapes) {
    CodeTable table;
    for (int m = 0; m < shapes; ++m) {
        for (const std::vector<float>& level : levels) {
            const std::size_t width = level.size() / static_cast<std::size_t>(shapes);
            for (std::size_t k = 0; k < width; ++k) {
                table.values.push_back(level[static_cast<std::size_t>(m) * width + k]);
            }
        }
    }
    table.code_count = static_cast<int>(table.values.size()) / shapes;
    return table;
}

}  // namespace mscomp::nn
