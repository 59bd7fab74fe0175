// SPDX-License-Identifier: MIT
#include "intrinsic_delaunay.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Flipping ends by itself in exact arithmetic; this stops it where rounding keeps it going.
constexpr long kFlipsPerEdge = 100;
/// Cotangent sums above this count as non-negative, so that cocircular corners are left alone.
constexpr double kNegligible = 1e-9;

/// Side k of triangle t has the number 3 t + k; next and previous go around its triangle.
int next(int side) { return side % 3 == 2 ? side - 2 : side + 1; }
int previous(int side) { return side % 3 == 0 ? side + 2 : side - 1; }

class Flipper {
  public:
    explicit Flipper(std::vector<EdgeLengths>& triangles);
    long run();

  private:
    int& corner(int side) { return triangles_[at(side / 3)].corners[at(side % 3)]; }
    double& length(int side) { return triangles_[at(side / 3)].lengths[at(side % 3)]; }
    int& twin(int side) { return twins_[at(side)]; }

    double opposite_cotangent(int side);
    bool is_delaunay(int side);
    void flip(int side);
    void push(int side);

    std::vector<EdgeLengths>& triangles_;
    std::vector<int> twins_;  // (3F) the same edge in the neighbouring triangle, -1 if it is fixed
    std::vector<int> stack_;
    std::vector<bool> stacked_;
};

Flipper::Flipper(std::vector<EdgeLengths>& triangles)
    : triangles_(triangles), twins_(triangles.size() * 3, -1), stacked_(twins_.size(), false) {
    struct Side {
        int low, high, number;
    };
    std::vector<Side> sides;
    for (int side = 0; side < static_cast<int>(twins_.size()); ++side) {
        const auto [low, high] = std::minmax({corner(side), corner(next(side))});
        sides.push_back({low, high, side});
    }
    const auto same = [](const Side& a, const Side& b) {
        return a.low == b.low && a.high == b.high;
    };
    std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) {
        if (!same(a, b)) return a.low != b.low ? a.low < b.low : a.high < b.high;
        return a.number < b.number;
    });
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && same(sides[begin], sides[end])) ++end;
        const int first = sides[begin].number;
        const int last = sides[end - 1].number;
        if (end - begin == 2 && corner(first) != corner(last)) {
            twin(first) = last;
            twin(last) = first;
        }
    }
}

double Flipper::opposite_cotangent(int side) {
    const auto& lengths = triangles_[at(side / 3)].lengths;
    const double base = length(side), right = length(next(side)), left = length(previous(side));
    return (right * right + left * left - base * base) / (4 * area_of(lengths));
}

bool Flipper::is_delaunay(int side) {
    const int other = twin(side);
    if (other < 0 || other / 3 == side / 3) return true;
    return opposite_cotangent(side) + opposite_cotangent(other) >= -kNegligible;
}

void Flipper::push(int side) {
    if (twin(side) < 0) return;
    const auto lower = at(std::min(side, twin(side)));
    if (stacked_[lower]) return;
    stacked_[lower] = true;
    stack_.push_back(static_cast<int>(lower));
}

/// Triangles (a, b, c) and (b, a, d) across side ab become (a, d, c) and (d, b, c).
void Flipper::flip(int side) {
    const int other = twin(side);
    const int t = side / 3 * 3, s = other / 3 * 3;
    const std::array<int, 4> before{next(other), previous(side), previous(other), next(side)};
    const std::array<int, 4> after{t, t + 2, s, s + 1};  // a-d, c-a, d-b, b-c
    const int a = corner(side), b = corner(other);
    const int c = corner(previous(side)), d = corner(previous(other));

    // Laid flat with a at the origin and b on the x axis, c above it and d below.
    const double ab = length(side);
    const auto foot = [ab](double from_a, double from_b) {
        return 0.5 * (ab + (from_a - from_b) * (from_a + from_b) / ab);
    };
    const double cx = foot(length(before[1]), length(before[3]));
    const double dx = foot(length(before[0]), length(before[2]));
    const double cy = 2 * area_of(triangles_[at(t / 3)].lengths) / ab;
    const double dy = 2 * area_of(triangles_[at(s / 3)].lengths) / ab;
    const double cd = std::hypot(cx - dx, cy + dy);

    std::array<double, 4> lengths{};
    std::array<int, 4> twins{};
    for (std::size_t k = 0; k < 4; ++k) {
        lengths[k] = length(before[k]);
        twins[k] = twin(before[k]);
        // An outer side may be glued to another outer side of the same two triangles.
        const auto inside = std::find(before.begin(), before.end(), twins[k]);
        if (inside != before.end()) {
            twins[k] = after[at(inside - before.begin())];
        }
    }
    triangles_[at(t / 3)] = {{a, d, c}, {lengths[0], cd, lengths[1]}};
    triangles_[at(s / 3)] = {{d, b, c}, {lengths[2], lengths[3], cd}};
    for (std::size_t k = 0; k < 4; ++k) {
        twin(after[k]) = twins[k];
        if (twins[k] >= 0) twin(twins[k]) = after[k];
    }
    twin(t + 1) = s + 2;
    twin(s + 2) = t + 1;
    for (const int outer : after) push(outer);
}

long Flipper::run() {
    for (int side = static_cast<int>(twins_.size()); side-- > 0;) push(side);
    const long limit = kFlipsPerEdge * static_cast<long>(twins_.size());
    long flips = 0;
    while (!stack_.empty() && flips < limit) {
        const int side = stack_.back();
        stack_.pop_back();
        stacked_[at(side)] = false;
        if (is_delaunay(side)) continue;
        flip(side);
        ++flips;
    }
    return flips;
}

}  // namespace

double area_of(const std::array<double, 3>& lengths) {
    std::array<double, 3> s = lengths;
    std::sort(s.begin(), s.end(), std::greater<>());
    const auto& [a, b, c] = s;
    const double product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
    return 0.25 * std::sqrt(std::max(product, 0.0));
}

long make_intrinsic_delaunay(std::vector<EdgeLengths>& triangles) {
    return Flipper(triangles).run();
}

}  // namespace mscomp
