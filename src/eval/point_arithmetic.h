// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

inline double square_distance(const Point& p, const Point& q) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (p[k] - q[k]) * (p[k] - q[k]);
    return sum;
}

inline Point centroid(const std::vector<Point>& points) {
    Point sum{0, 0, 0};
    for (const Point& p : points) {
        for (std::size_t k = 0; k < 3; ++k) sum[k] += p[k] / static_cast<double>(points.size());
    }
    return sum;
}

}  // namespace mscomp
