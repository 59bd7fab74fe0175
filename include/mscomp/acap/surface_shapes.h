// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mscomp/base/shape_features.h"
#include "mscomp/base/vertex_places.h"

namespace mscomp {

/// Shapes of V vertices as shapes of their W places: what models know of them. Where every vertex
/// is a place of its own rows are handed on where they lie; otherwise those that were asked for
/// stay in memory, as others may still look at them.
class SurfaceShapes final : public ShapeSet {
  public:
    /// Borrows both.
    SurfaceShapes(const ShapeSet& shapes, const VertexPlaces& places);
    ~SurfaceShapes() override;

    int shape_count() const override { return shapes_.shape_count(); }
    int vertex_count() const override { return places_.place_count(shapes_.vertex_count()); }
    std::span<const float> shape(int index) const override;     // (W,9)
    std::span<const float> vertices(int index) const override;  // (W,3)
    void forget(int index) const override { shapes_.forget(index); }

  private:
    struct Rows;

    const ShapeSet& shapes_;
    const VertexPlaces& places_;
    std::unique_ptr<Rows[]> features_, vertices_;  // (N) each, filled when asked for
};

}  // namespace mscomp
