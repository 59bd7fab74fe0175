// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/channel_scale.h"
#include "mscomp/base/feature_set.h"
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
    float root(int v) const { return roots_[at(v)]; }
    /// Overwrites `to` with one row (V,9) of features, mapped.
    void map(std::span<const float> features, std::span<float> to) const;
    /// A row (V,9) back to features, in place.
    void unmap(std::span<float> row) const;
    /// Nine values at vertex v as a difference of features, in place.
    void unmap_change(int v, std::span<float> values) const;
    /// What the features of a vertex change by where a mapped value changes by 1.
    double unmap_factor(int v, std::size_t channel) const {
        const double factor = scale_.factor[channel];
        return factor != 0 ? 1 / (factor * static_cast<double>(roots_[at(v)])) : 0;
    }
    double offset(std::size_t channel) const { return scale_.offset[channel]; }

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
    /// Entry `i` of the row (V,9) of shape m.
    float value(std::size_t i, int m) const { return values_[i * at(shapes_) + at(m)]; }
    void set(std::size_t i, int m, float value) { values_[i * at(shapes_) + at(m)] = value; }

  private:
    int vertices_, shapes_;
    std::vector<float> values_;
};

}  // namespace mscomp
