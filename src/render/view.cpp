// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mscomp/base/error.h"
#include "mscomp/base/points.h"
#include "mscomp/render/render.h"

namespace mscomp {
namespace {

constexpr double kMargin = 1.04;
constexpr double kTurn = 30 * std::numbers::pi / 180;
constexpr double kElevation = 12 * std::numbers::pi / 180;
/// How much longer than y another axis has to be to count as up.
constexpr double kUpright = 2;

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

std::array<Point, 3> axes_for(const std::array<Interval, 3>& box) {
    std::size_t up = 1;
    for (const std::size_t other : {std::size_t{0}, std::size_t{2}}) {
        const bool upright = box[other].extent() > kUpright * box[1].extent();
        if (upright && box[other].extent() > box[up].extent()) up = other;
    }
    const std::size_t first = (up + 1) % 3, second = (up + 2) % 3;
    const std::size_t depth = box[first].extent() < box[second].extent() ? first : second;
    Point up_axis{0, 0, 0}, front{0, 0, 0};
    up_axis[up] = 1;
    front[depth] = up == 1 ? 1 : -1;
    const Point side = cross(up_axis, front);
    const Point turned = combine(std::cos(kTurn), front, std::sin(kTurn), side);
    const Point viewer = combine(std::cos(kElevation), turned, std::sin(kElevation), up_axis);
    const Point right = cross(up_axis, turned);
    return {right, cross(viewer, right), viewer};
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
    view.axes = axes_for(ranges_along(vertices, view.axes));
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
