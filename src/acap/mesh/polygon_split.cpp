// SPDX-License-Identifier: MIT
#include "polygon_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <tuple>

#include "face_comparison.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Vector = std::array<double, 3>;
using Corners = std::vector<std::array<std::size_t, 3>>;  // of triangles

Vector difference(const Point& a, const Point& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// One polygon in its plane. Corners are numbered from the lowest vertex on, towards the lower one
/// of its two neighbours, whichever way the file goes around: all decisions and all rounding are
/// then the same for every way of writing it down.
class FlatPolygon {
  public:
    FlatPolygon(std::span<const int> corners, const std::vector<Point>& positions) {
        const std::size_t count = corners.size(), start = smallest_rotation(corners);
        vertices_.reserve(count);
        for (std::size_t i = 0; i < count; ++i) vertices_.push_back(corners[(start + i) % count]);
        reversed_ = vertices_.back() < vertices_[1];
        if (reversed_) std::reverse(vertices_.begin() + 1, vertices_.end());
        flatten(positions);
    }

    std::size_t count() const { return vertices_.size(); }
    int vertex(std::size_t corner) const { return vertices_[corner]; }
    double x(std::size_t corner) const { return flat_[corner][0]; }

    /// Twice the area of a triangle of corners; positive where it turns as the polygon does.
    double turn(std::size_t a, std::size_t b, std::size_t c) const {
        const auto& [ax, ay] = flat_[a];
        const auto& [bx, by] = flat_[b];
        const auto& [cx, cy] = flat_[c];
        return (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    }
    bool is_positive(std::size_t a, std::size_t b, std::size_t c) const {
        return turn(a, b, c) > smallest_;
    }
    /// Whether corner `p`, which lies elsewhere than a, b and c, is within their triangle.
    bool is_within(std::size_t p, std::size_t a, std::size_t b, std::size_t c) const {
        if (flat_[p] == flat_[a] || flat_[p] == flat_[b] || flat_[p] == flat_[c]) return false;
        return turn(a, b, p) >= -smallest_ && turn(b, c, p) >= -smallest_ &&
               turn(c, a, p) >= -smallest_;
    }

    /// Appends triangles, ascending and each from its lowest corner on, in the file's direction.
    void append(const Corners& triangles, std::vector<Face>& faces) const {
        const auto first = static_cast<std::ptrdiff_t>(faces.size());
        for (const auto& [a, b, c] : triangles) {
            faces.push_back(
                {vertices_[a], vertices_[reversed_ ? c : b], vertices_[reversed_ ? b : c]});
        }
        if (reversed_) std::reverse(faces.begin() + first, faces.end());
    }

  private:
    /// Projects onto the plane of the largest area, whose normal is the sum of the triangles of any
    /// fan (Newell).
    void flatten(const std::vector<Point>& positions) {
        const Point& origin = positions[at(vertices_.front())];
        Vector normal{};
        for (std::size_t i = 2; i < count(); ++i) {
            const Vector part = cross(difference(positions[at(vertices_[i - 1])], origin),
                                      difference(positions[at(vertices_[i])], origin));
            for (std::size_t k = 0; k < 3; ++k) normal[k] += part[k];
        }
        const double size = std::sqrt(dot(normal, normal));
        flat_.assign(count(), {0, 0});
        if (!(size > 0) || !std::isfinite(size)) return;
        for (double& component : normal) component /= size;
        // The axis along which the normal is shortest is far from it.
        const auto shortest =
            std::min_element(normal.begin(), normal.end(),
                             [](double a, double b) { return std::abs(a) < std::abs(b); });
        Vector axis{};
        axis[at(shortest - normal.begin())] = 1;
        const Vector u = cross(axis, normal), v = cross(normal, u);
        for (std::size_t i = 0; i < count(); ++i) {
            const Vector offset = difference(positions[at(vertices_[i])], origin);
            flat_[i] = {dot(offset, u), dot(offset, v)};
        }
        constexpr double rounding = 1e-12;  // of the area: beneath it a sign means nothing
        smallest_ = rounding * size * dot(u, u);
    }

    std::vector<int> vertices_;
    bool reversed_ = false;
    std::vector<std::array<double, 2>> flat_;
    double smallest_ = 0;
};

Corners fan_of(std::size_t count) {
    Corners triangles;
    for (std::size_t i = 2; i < count; ++i) triangles.push_back({0, i - 1, i});
    return triangles;
}

/// The diagonal of the lowest corner if it lies within, or else the other one if that does.
Corners split_quad(const FlatPolygon& quad) {
    const auto is_inner = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
        return quad.is_positive(a, b, c) && quad.is_positive(a, c, d);
    };
    if (!is_inner(0, 1, 2, 3) && is_inner(1, 2, 3, 0)) return {{0, 1, 3}, {1, 2, 3}};
    return fan_of(4);
}

/// Cuts off ears: corners whose two neighbours see each other. Work is limited; beyond that a
/// corner is taken for none.
class EarClipping {
  public:
    explicit EarClipping(const FlatPolygon& polygon)
        : polygon_(polygon), next_(polygon.count()), previous_(polygon.count()) {
        const std::size_t count = polygon.count();
        for (std::size_t i = 0; i < count; ++i) {
            next_[i] = (i + 1) % count;
            previous_[i] = (i + count - 1) % count;
        }
        // Only corners that turn the other way can lie in an ear.
        for (std::size_t i = 0; i < count; ++i) {
            if (!is_convex(i)) hollow_.emplace(polygon_.x(i), i);
        }
        for (std::size_t i = 0; i < count; ++i) add_if_ear(i);
    }

    /// What is left when there is no ear any more, of a contour that is not simple, is a fan.
    Corners triangles() {
        Corners found;
        while (found.size() + 2 < polygon_.count() && !ears_.empty()) {
            const std::size_t tip = std::get<2>(*ears_.begin());
            found.push_back({previous_[tip], tip, next_[tip]});
            cut(tip);
        }
        std::size_t first = 0;
        while (next_[first] == first) ++first;
        for (std::size_t b = next_[first]; found.size() + 2 < polygon_.count(); b = next_[b]) {
            found.push_back({first, b, next_[b]});
        }
        return found;
    }

  private:
    static constexpr std::int64_t kMostTests = 100'000'000;
    using Key = std::tuple<int, int, std::size_t>;  // lower neighbour, own vertex, corner

    Key key_of(std::size_t corner) const {
        const int neighbor =
            std::min(polygon_.vertex(previous_[corner]), polygon_.vertex(next_[corner]));
        return {neighbor, polygon_.vertex(corner), corner};
    }
    bool is_convex(std::size_t corner) const {
        return polygon_.is_positive(previous_[corner], corner, next_[corner]);
    }
    void add_if_ear(std::size_t corner) {
        if (is_convex(corner) && !holds_a_corner(corner)) ears_.insert(key_of(corner));
    }
    bool holds_a_corner(std::size_t corner) const {
        const std::size_t before = previous_[corner], behind = next_[corner];
        const auto [low, high] =
            std::minmax({polygon_.x(before), polygon_.x(corner), polygon_.x(behind)});
        for (auto near = hollow_.lower_bound({low, 0});
             near != hollow_.end() && near->first <= high; ++near) {
            if (++tests_ > kMostTests) return true;
            if (polygon_.is_within(near->second, before, corner, behind)) return true;
        }
        return false;
    }

    void cut(std::size_t tip) {
        const std::size_t before = previous_[tip], behind = next_[tip];
        for (const std::size_t corner : {before, tip, behind}) ears_.erase(key_of(corner));
        next_[before] = behind;
        previous_[behind] = before;
        next_[tip] = tip;  // gone
        for (const std::size_t corner : {before, behind}) {
            if (is_convex(corner)) hollow_.erase({polygon_.x(corner), corner});
            add_if_ear(corner);
        }
    }

    const FlatPolygon& polygon_;
    std::vector<std::size_t> next_, previous_;         // around what is left
    std::set<std::pair<double, std::size_t>> hollow_;  // corners that are not convex, by x
    std::set<Key> ears_;
    mutable std::int64_t tests_ = 0;
};

Corners split(const FlatPolygon& polygon) {
    if (polygon.count() == 4) return split_quad(polygon);
    Corners triangles = EarClipping(polygon).triangles();
    for (auto& corners : triangles) {
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

}  // namespace

SplitFaces split_into_triangles(const PolygonMesh& mesh, const std::vector<Point>& positions) {
    SplitFaces result;
    const std::size_t count = mesh.corners.size() - 2 * mesh.face_count();
    result.faces.reserve(count);
    result.face_numbers.reserve(count);
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
        const std::span<const int> corners = mesh.face(f);
        if (corners.size() == 3) {
            result.faces.push_back({corners[0], corners[1], corners[2]});
        } else {
            const FlatPolygon polygon(corners, positions);
            polygon.append(split(polygon), result.faces);
        }
        result.face_numbers.resize(result.faces.size(), static_cast<int>(mesh.file_number(f)));
    }
    return result;
}

}  // namespace mscomp
