// SPDX-License-Identifier: MIT
#include "mscomp/base/points.h"

#include <cmath>
#include <limits>

namespace mscomp {

double unit_ball_scale(const std::vector<Point>& reference) {
    const Point center = centroid(reference);
    double farthest = 0;
    for (const Point& p : reference) {
        const double square = square_distance(p, center);
        // std::max would forget a NaN.
        if (!(square <= farthest)) farthest = square;
        if (std::isnan(farthest)) break;
    }
    const double scale = 1 / std::sqrt(farthest);
    return scale > 0 && std::isfinite(scale) ? scale : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace mscomp
