// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/index.h"

namespace mscomp {

/// Scaled features of some shapes, those of one channel of a vertex side by side: (V,9,shapes).
class MetricRows {
  public:
    MetricRows(int vertices, int shapes)
        : vertices_(vertices), shapes_(shapes), values_(at(vertices) * 9 * at(shapes)) {}

    int vertex_count() const { return vertices_; }
    int shape_count() const { return shapes_; }
    /// (9,shapes) of a vertex.
    std::span<const float> vertex(int v) const {
        const std::size_t size = 9 * at(shapes_);
        return std::span(values_).subspan(at(v) * size, size);
    }
    std::span<const float> all() const { return values_; }
    /// Shape m is `row` (V,9).
    void set(int m, std::span<const float> row);
    /// Entry `i` of the row (V,9) of shape m.
    float value(std::size_t i, int m) const { return values_[i * at(shapes_) + at(m)]; }
    void set(std::size_t i, int m, float value) { values_[i * at(shapes_) + at(m)] = value; }

  private:
    int vertices_, shapes_;
    std::vector<float> values_;
};

}  // namespace mscomp
