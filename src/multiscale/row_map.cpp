// SPDX-License-Identifier: MIT
#include "multiscale/row_map.h"

#include <algorithm>

#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {

RowMap::RowMap(const TriangleMesh& reference) : reference_(&reference) {
    const double scale = unit_ball_scale(reference.vertices);
    unit_ = scale > 0 ? 1 / scale : 1;
}

std::vector<float> RowMap::mapped(const ShapeSet& shapes, int index) const {
    const bool is_features = rows() == ShapeRows::features;
    const std::span<const float> row = is_features ? shapes.shape(index) : shapes.vertices(index);
    std::vector<float> result(row.begin(), row.end());
    shapes.forget(index);
    if (is_features) {
        scale_.scale(result);
        return result;
    }
    for (std::size_t i = 0; i < result.size(); ++i) {
        const double rest = reference_->vertices[i / 3][i % 3];
        result[i] = static_cast<float>((static_cast<double>(result[i]) - rest) / unit_);
    }
    return result;
}

double RowMap::factor(int v, std::size_t channel) const {
    return rows() == ShapeRows::features ? scale_.scale_factor(at(v), channel) : 1 / unit_;
}

void RowMap::unmap(std::span<float> row) const {
    if (rows() == ShapeRows::features) {
        scale_.unscale(row);
        return;
    }
    for (std::size_t i = 0; i < row.size(); ++i) {
        const double rest = reference_->vertices[i / 3][i % 3];
        row[i] = static_cast<float>(rest + static_cast<double>(row[i]) * unit_);
    }
}

void RowMap::unmap_change(int v, std::span<float> values) const {
    if (rows() == ShapeRows::features) {
        scale_.unscale_change(v, values);
        return;
    }
    for (float& x : values) x = static_cast<float>(static_cast<double>(x) * unit_);
}

}  // namespace mscomp
