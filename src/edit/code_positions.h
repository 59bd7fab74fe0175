// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "mscomp/acap/feature_scaler.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/edit/vertex_fit.h"
#include "nn/code_decoder.h"

namespace mscomp {

/// Positions as a function of codes: decoder, scaler backwards, solver. Borrows the decoder.
class CodePositions {
  public:
    CodePositions(const nn::CodeDecoder& decoder, const FeatureScaler& scaler,
                  const TriangleMesh& reference, EdgeWeights weights, VertexSolver solver);

    int code_count() const { return decoder_.code_count(); }
    int vertex_count() const { return decoder_.vertex_count(); }

    /// (V,9), unscaled.
    std::vector<float> features(std::span<const float> codes) const;
    /// (V) of features, as the solver places them.
    std::vector<Point> positions(std::span<const float> features,
                                 std::span<const Point> like) const;
    /// (n,V,3) in n of the codes `which` at `codes`, whose features are given; `lossless`: of its
    /// linear part.
    std::vector<double> derivatives(std::span<const float> codes, std::span<const float> features,
                                    std::span<const int> which) const;

  private:
    const nn::CodeDecoder& decoder_;
    FeatureScaler scaler_;
    std::optional<PoissonReconstruction> poisson_;  // one of these
    std::optional<LosslessReconstruction> lossless_;
};

}  // namespace mscomp
