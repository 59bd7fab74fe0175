// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/points.h"
#include "mscomp/render/render.h"
#include "mscomp/render/viewpoint.h"

namespace mscomp {
namespace {

constexpr double kMargin = 1.04;
constexpr Viewpoint kAcross{30, 12};

Point combine(double a, const Point& p, double b, const Point& q) {
    return {a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2]};
}

struct Interval {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void include(double value) {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    double extent() const { return high - low; }
    double middle() const { return low + 0.5 * (high - low); }
};

std::array<Interval, 3> ranges_along(std::span<const Point> vertices,
                                     const std::array<Point, 3>& axes) {
    std::array<Interval, 3> ranges;
    for (const Point& p : vertices) {
        for (std::size_t k = 0; k < 3; ++k) ranges[k].include(dot(p, axes[k]));
    }
    return ranges;
}

void require_finite(std::span<const Point> vertices) {
    if (vertices.empty()) throw MeshError("render: nothing to look at, the mesh has no vertices");
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const Point& p = vertices[i];
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
            throw MeshError(fmt::format("render: vertex {} is ({}, {}, {}), wanted finite numbers",
                                        i, p[0], p[1], p[2]));
        }
    }
}

}  // namespace

View fit_view(std::span<const Point> vertices, double picture_aspect) {
    require_finite(vertices);
    View view;
    view.axes = axes_from(stance_of(vertices), kAcross);
    return framed(view, vertices, picture_aspect);
}

View framed(View view, std::span<const Point> vertices, double picture_aspect) {
    require_finite(vertices);
    const std::array<Interval, 3> seen = ranges_along(vertices, view.axes);
    view.center = {0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
        view.center = combine(1, view.center, seen[k].middle(), view.axes[k]);
    }
    const double half_width = 0.5 * seen[0].extent(), half_height = 0.5 * seen[1].extent();
    const double fitted = picture_aspect >= 1 ? std::max(half_width / picture_aspect, half_height)
                                              : std::max(half_width, half_height * picture_aspect);
    // A single point has no extent: any frame around it will do.
    view.half_extent = fitted > 0 ? kMargin * fitted : 1.0;
    view.aspect = half_width > 0 && half_height > 0 ? half_width / half_height : 1.0;
    return view;
}

std::array<int, 2> picture_size(const View& view, int longer_side) {
    const double aspect = std::clamp(view.aspect, 0.5, 1.6);
    const auto shorter = [&](double share) {
        return std::max(1, static_cast<int>(std::lround(share * longer_side)));
    };
    if (aspect >= 1) return {longer_side, shorter(1 / aspect)};
    return {shorter(aspect), longer_side};
}

}  // namespace mscomp
