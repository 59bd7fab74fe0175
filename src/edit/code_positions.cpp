// SPDX-License-Identifier: MIT
#include "code_positions.h"

#include "mscomp/base/index.h"

namespace mscomp {

CodePositions::CodePositions(const nn::CodeDecoder& decoder, const FeatureScaler& scaler,
                             const TriangleMesh& reference, EdgeWeights weights,
                             VertexSolver solver)
    : decoder_(decoder), scaler_(scaler) {
    if (solver == VertexSolver::poisson) {
        poisson_.emplace(reference, weights);
    } else {
        lossless_.emplace(reference, weights);
    }
}

std::vector<float> CodePositions::features(std::span<const float> codes) const {
    std::vector<float> result = decoder_.decode(codes);
    scaler_.unscale(result);
    return result;
}

std::vector<Point> CodePositions::positions(std::span<const float> features,
                                            std::span<const Point> like) const {
    return poisson_ ? poisson_->solve(features, like) : lossless_->solve(features, like).vertices;
}

std::vector<double> CodePositions::derivatives(std::span<const float> codes,
                                               std::span<const float> features,
                                               std::span<const int> which) const {
    std::vector<nn::DecoderColumn> columns = decoder_.derivatives(codes);
    std::vector<FeatureDirection> directions;
    for (const int code : which) {
        nn::DecoderColumn& column = columns[at(code)];
        for (std::size_t n = 0; n < column.values.size(); ++n) {
            const double factor = scaler_.factor[n % kFeatureDim];
            const auto value = static_cast<double>(column.values[n]);
            column.values[n] = factor != 0 ? static_cast<float>(value / factor) : 0.0F;
        }
        directions.push_back({column.vertices, column.values});
    }
    std::vector<double> result(which.size() * 3 * at(vertex_count()));
    if (poisson_) {
        poisson_->derivatives(features, directions, result);
    } else {
        lossless_->derivatives(features, directions, result);
    }
    return result;
}

}  // namespace mscomp
