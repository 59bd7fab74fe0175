// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/acap/mirror.h"
#include "mscomp/base/made_rows.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {

/// Features of N shapes, and behind them those of their mirror images: shape N + i has at vertex v
/// r' = -M r and S' = M S Mᵀ, where (r, S) is what shape i has at the partner of v, interpolated
/// between the corners (a rotation vector is a pseudo-vector, and det M = -1). On a mesh whose
/// vertices are mirror images of each other these are the features of the mirrored shapes.
class MirroredFeatures final : public ShapeFeatures {
  public:
    /// Borrows both, which have the same V.
    MirroredFeatures(const ShapeFeatures& features, const Mirror& mirror);

    int shape_count() const override { return 2 * features_.shape_count(); }
    int vertex_count() const override { return features_.vertex_count(); }
    /// Rows of mirrored shapes are made when they are asked for and kept until forgotten. Safe to
    /// call from several threads.
    std::span<const float> shape(int index) const override;
    void forget(int index) const override;

  private:
    std::vector<float> mirrored_row(int index) const;

    const ShapeFeatures& features_;
    const Mirror& mirror_;
    mutable MadeRows rows_;
};

}  // namespace mscomp
