// SPDX-License-Identifier: MIT
#include "multiscale/row_map.h"

#include "mscomp/acap/alignment.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {

RowMap::RowMap(const TriangleMesh& reference) : reference_(&reference) {
    const double scale = unit_ball_scale(reference.vertices);
    unit_ = scale > 0 ? 1 / scale : 1;
}

std::vector<float> RowMap::mapped(const ShapeSet& shapes, int index) const {
    if (rows() == ShapeRows::features) {
        const std::span<const float> row = shapes.shape(index);
        std::vector<float> result(row.begin(), row.end());
        shapes.forget(index);
        scale_.scale(result);
        return result;
    }
    const std::vector<Point> points = points_of(shapes.vertices(index));
    shapes.forget(index);
    const std::vector<Point> placed = moved(points, resting_motion(points, reference_->vertices));
    std::vector<float> result;
    result.reserve(3 * placed.size());
    for (std::size_t v = 0; v < placed.size(); ++v) {
        for (std::size_t x = 0; x < 3; ++x) {
            result.push_back(
                static_cast<float>((placed[v][x] - reference_->vertices[v][x]) / unit_));
        }
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
