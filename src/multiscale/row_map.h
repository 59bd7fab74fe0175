// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/base/shape_features.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// The map of the rows of a shape to those that components are made of, (V,width): zero at the
/// reference, a factor for each number. Features are mapped as their scale says; positions to their
/// change from the reference, as a part of its radius, so that no unit of length matters, where
/// what rests lies on it (resting_motion): the best rigid motion of a face whose jaw drops tilts
/// all of it, and every vertex would seem to move.
class RowMap {
  public:
    /// Of features.
    explicit RowMap(MetricScale scale) : scale_(std::move(scale)) {}
    /// Of positions; borrows the reference.
    explicit RowMap(const TriangleMesh& reference);

    ShapeRows rows() const {
        return reference_ == nullptr ? ShapeRows::features : ShapeRows::positions;
    }
    int width() const { return row_width(rows()); }
    /// As ShapeModel::unit.
    double unit() const { return unit_; }
    /// Of features; that of a map of positions does nothing.
    const MetricScale& scale() const { return scale_; }

    /// Those of shape `index`, which is forgotten.
    std::vector<float> mapped(const ShapeSet& shapes, int index) const;
    /// What a mapped number changes by where that of the row changes by 1.
    double factor(int v, std::size_t channel) const;
    /// Rows from mapped ones, in place.
    void unmap(std::span<float> row) const;
    /// The mapped numbers of vertex v as a difference of rows, in place.
    void unmap_change(int v, std::span<float> values) const;

  private:
    MetricScale scale_;
    const TriangleMesh* reference_ = nullptr;  // of positions
    double unit_ = 1;
};

}  // namespace mscomp
