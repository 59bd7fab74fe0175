// SPDX-License-Identifier: MIT
#include "mscomp/render/viewpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/parsed_number.h"
#include "mscomp/base/points.h"
#include "mscomp/base/printable.h"

namespace mscomp {
namespace {

/// How much longer than y another axis has to be to count as up.
constexpr double kUpright = 2;
/// Length of the mean normal from which a surface counts as open to one side.
constexpr double kOpen = 0.15;
/// cos 30 degrees: how near a coordinate axis a front is taken to be along it.
constexpr double kNearAxis = 0.866;

Point mixed(double a, const Point& p, double b, const Point& q) {
    return {a * p[0] + b * q[0], a * p[1] + b * q[1], a * p[2] + b * q[2]};
}

Point extents_of(std::span<const Point> vertices) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Point low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    for (const Point& p : vertices) {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    return minus(high, low);
}

std::size_t axis_along(const Point& p) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) {
        if (std::abs(p[k]) > std::abs(p[axis])) axis = k;
    }
    return axis;
}

constexpr std::array<std::pair<std::string_view, Viewpoint>, 6> kNamed{{{"front", {0, 0}},
                                                                        {"back", {180, 0}},
                                                                        {"left", {270, 0}},
                                                                        {"right", {90, 0}},
                                                                        {"top", {0, 90}},
                                                                        {"bottom", {0, -90}}}};

}  // namespace

Stance stance_of(std::span<const Point> vertices) {
    const Point extents = extents_of(vertices);
    std::size_t up = 1;
    for (const std::size_t other : {std::size_t{0}, std::size_t{2}}) {
        if (extents[other] > kUpright * extents[1] && extents[other] > extents[up]) up = other;
    }
    Point axis{0, 0, 0};
    axis[up] = 1;
    return stance_of(vertices, axis);
}

Stance stance_of(std::span<const Point> vertices, const Point& up) {
    const Point extents = extents_of(vertices);
    const std::size_t axis = axis_along(up);
    const std::size_t first = (axis + 1) % 3, second = (axis + 2) % 3;
    Stance stance{up, {0, 0, 0}};
    stance.front[extents[first] < extents[second] ? first : second] = axis == 1 ? 1 : -1;
    return stance;
}

bool face_open_front(const TriangleMesh& mesh, Stance& stance) {
    Point sum{0, 0, 0};
    double area = 0;
    for (const Face& face : mesh.faces) {
        const Point& p = mesh.vertices[at(face[0])];
        const Point normal =
            cross(minus(mesh.vertices[at(face[1])], p), minus(mesh.vertices[at(face[2])], p));
        area += std::hypot(normal[0], normal[1], normal[2]);
        sum = mixed(1, sum, 1, normal);
    }
    const Point level = mixed(1, sum, -dot(sum, stance.up), stance.up);
    const double length = std::hypot(level[0], level[1], level[2]);
    if (!(length >= kOpen * area) || !(area > 0)) return false;
    stance.front = mixed(1 / length, level, 0, level);
    const std::size_t axis = axis_along(stance.front);
    if (std::abs(stance.front[axis]) > kNearAxis && std::abs(stance.up[axis]) < 0.5) {
        const double sign = stance.front[axis] > 0 ? 1 : -1;
        stance.front = {0, 0, 0};
        stance.front[axis] = sign;
    }
    return true;
}

std::array<Point, 3> axes_from(const Stance& stance, const Viewpoint& viewpoint) {
    const double turn = viewpoint.azimuth * std::numbers::pi / 180;
    const double rise = viewpoint.elevation * std::numbers::pi / 180;
    const Point side = cross(stance.up, stance.front);
    const Point turned = mixed(std::cos(turn), stance.front, std::sin(turn), side);
    const Point viewer = mixed(std::cos(rise), turned, std::sin(rise), stance.up);
    const Point right = cross(stance.up, turned);
    return {right, cross(viewer, right), viewer};
}

std::string name_of(const Viewpoint& viewpoint) {
    static constexpr std::array<const char*, 8> kNames{
        "front", "front right", "right", "back right", "back", "back left", "left", "front left"};
    const long eighth = std::lround(viewpoint.azimuth / 45) % 8;
    std::string side = kNames[static_cast<std::size_t>((eighth + 8) % 8)];
    if (viewpoint.elevation > 75) return "above";
    if (viewpoint.elevation < -75) return "below";
    if (viewpoint.elevation > 35) return "above, " + side;
    if (viewpoint.elevation < -35) return "below, " + side;
    return side;
}

std::string axis_name(const Point& direction) {
    const std::size_t axis = axis_along(direction);
    if (std::abs(direction[axis]) > 1 - 1e-9) {
        return fmt::format("{}{}", direction[axis] > 0 ? '+' : '-', "xyz"[axis]);
    }
    return fmt::format("({:.2g}, {:.2g}, {:.2g})", direction[0], direction[1], direction[2]);
}

Point parse_axis(std::string_view text) {
    const std::string_view letter = text.starts_with('-') ? text.substr(1) : text;
    if (letter.size() != 1 || letter[0] < 'x' || letter[0] > 'z') {
        throw UsageError(
            fmt::format("--up: got '{}', wanted x, y, z, -x, -y or -z", printable(text)));
    }
    Point axis{0, 0, 0};
    axis[static_cast<std::size_t>(letter[0] - 'x')] = letter.size() == text.size() ? 1 : -1;
    return axis;
}

Viewpoint parse_viewpoint(std::string_view text) {
    for (const auto& [name, viewpoint] : kNamed) {
        if (text == name) return viewpoint;
    }
    const std::size_t comma = text.find(',');
    if (comma != std::string_view::npos) {
        const auto azimuth = parsed_number<double>(text.substr(0, comma));
        const auto elevation = parsed_number<double>(text.substr(comma + 1));
        if (azimuth && elevation && std::abs(*azimuth) <= 360 && std::abs(*elevation) <= 90) {
            return {*azimuth, *elevation};
        }
    }
    throw UsageError(fmt::format(
        "--view: got '{}', wanted front, back, left, right, top, bottom, or an azimuth and an "
        "elevation in degrees such as 30,10",
        printable(text)));
}

}  // namespace mscomp
