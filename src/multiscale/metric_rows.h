// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/channel_scale.h"
#include "mscomp/base/index.h"

namespace mscomp {

/// The map between features and what components describe: scaled around the reference, times the
/// root of the metric at each vertex.
class MetricScale {
  public:
    /// `roots` (V), positive.
    MetricScale(const ChannelScale& scale, std::vector<float> roots)
        : scale_(scale), roots_(std::move(roots)) {}

    int vertex_count() const { return static_cast<int>(roots_.size()); }
    std::span<const float> roots() const { return roots_; }
    /// Overwrites `to` with one row (V,9) of features, mapped.
    void map(std::span<const float> features, std::span<float> to) const;
    /// A row (V,9) back to features, in place.
    void unmap(std::span<float> row) const;
    /// Nine values at vertex v as a difference of features, in place.
    void unmap_change(int v, std::span<float> values) const;

  private:
    ChannelScale scale_;
    std::vector<float> roots_;
};

/// Mapped features of some shapes, those of one channel of a vertex side by side: (V,9,shapes).
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

  private:
    int vertices_, shapes_;
    std::vector<float> values_;
};

}  // namespace mscomp
