// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"

namespace mscomp {

/// Mapped rows of some shapes (row_map.h), those of one channel of a vertex side by side:
/// (V,width,shapes).
class MetricRows {
  public:
    MetricRows(int vertices, int shapes, int width = kFeatureDim)
        : vertices_(vertices),
          shapes_(shapes),
          width_(width),
          values_(at(vertices) * at(width) * at(shapes)) {}

    int vertex_count() const { return vertices_; }
    int shape_count() const { return shapes_; }
    int width() const { return width_; }
    /// (width,shapes) of a vertex.
    std::span<const float> vertex(int v) const {
        const std::size_t size = at(width_) * at(shapes_);
        return std::span(values_).subspan(at(v) * size, size);
    }
    std::span<const float> all() const { return values_; }
    /// Shape m is `row` (V,width).
    void set(int m, std::span<const float> row);
    /// That of shape m (V,width).
    std::vector<float> row(int m) const;
    /// Entry `i` of the row (V,width) of shape m.
    float value(std::size_t i, int m) const { return values_[i * at(shapes_) + at(m)]; }
    void set(std::size_t i, int m, float value) { values_[i * at(shapes_) + at(m)] = value; }

  private:
    int vertices_, shapes_, width_;
    std::vector<float> values_;
};

}  // namespace mscomp
