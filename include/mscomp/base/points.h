// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Arithmetic of points where Eigen would be more than is needed.
inline Point minus(const Point& p, const Point& q) {
    return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}

inline double dot(const Point& p, const Point& q) {
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

inline Point cross(const Point& p, const Point& q) {
    return {p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
}

inline double square_distance(const Point& p, const Point& q) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (p[k] - q[k]) * (p[k] - q[k]);
    return sum;
}

/// Mean of at least one point.
inline Point centroid(const std::vector<Point>& points) {
    Point sum{0, 0, 0};
    for (const Point& p : points) {
        for (std::size_t k = 0; k < 3; ++k) sum[k] += p[k] / static_cast<double>(points.size());
    }
    return sum;
}

/// 1 / max_i |p_i - centroid|: times this, the reference fits the unit ball around its centroid.
/// One scale for a whole set of shapes (method §6). NaN where that ball has no finite positive
/// radius.
double unit_ball_scale(const std::vector<Point>& reference);

}  // namespace mscomp
