// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/points.h"

namespace mscomp {

/// `result` moved to `truth` by the rigid motion (no scale, no mirror image) with the least sum of
/// squared distances. Throws MeshError if the numbers of vertices differ or are zero.
std::vector<Point> aligned_to(const std::vector<Point>& truth, const std::vector<Point>& result);

/// |p_i - q_i| of every vertex after the rigid alignment of `result`, (V) in the unit of the input.
/// Throws as aligned_to.
std::vector<double> vertex_distances(const std::vector<Point>& truth,
                                     const std::vector<Point>& result);

/// Pooled root-mean-square vertex error of method §6: shapes scaled so that the reference fits the
/// unit ball around its centroid, every result moved to its truth by the best rigid motion, E_rms =
/// 1000 |P - P'|_F / sqrt(3 N V). Add shapes one by one.
class RmsError {
  public:
    /// Throws MeshError if there are no vertices.
    explicit RmsError(const std::vector<Point>& reference);
    /// E_rms of this shape alone. Throws as aligned_to.
    double add(const std::vector<Point>& truth, const std::vector<Point>& result);
    int shape_count() const { return shapes_; }
    /// Of all shapes; NaN before the first.
    double value() const;

  private:
    double scale_;
    double squares_ = 0;
    double coordinates_ = 0;
    int shapes_ = 0;
};

/// |X - Y|_F^2 / |X|_F^2 of one shape, [A] eq. 8; infinite where X is zero and Y is not.
double relative_squared_error(std::span<const float> truth, std::span<const float> result);

}  // namespace mscomp
