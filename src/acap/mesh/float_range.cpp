// SPDX-License-Identifier: MIT
#include "float_range.h"

#include <algorithm>
#include <cmath>

namespace mscomp {
namespace {

// Leaves seven digits to details of a ten-millionth of the size.
constexpr double kSmallest = 1e-30;

double longest_side(const std::vector<Point>& shape) {
    double longest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [lowest, highest] = std::minmax_element(
            shape.begin(), shape.end(),
            [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; });
        if (lowest != shape.end()) longest = std::max(longest, (*highest)[axis] - (*lowest)[axis]);
    }
    return longest;
}

}  // namespace

double distance_from_origin(const std::vector<Point>& shape) {
    const double size = longest_side(shape);
    if (!(size > 0)) return 0;
    double farthest = 0;
    for (const Point& point : shape) {
        for (const double coordinate : point) farthest = std::max(farthest, std::abs(coordinate));
    }
    return farthest / size;
}

bool is_too_small_for_float(const std::vector<Point>& shape) {
    const double size = longest_side(shape);
    return size > 0 && size < kSmallest;
}

}  // namespace mscomp
