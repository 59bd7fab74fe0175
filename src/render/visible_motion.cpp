// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mscomp/base/points.h"
#include "mscomp/render/motion.h"

namespace mscomp {
namespace {

/// Samples along each side.
constexpr int kGrid = 64;
/// Motion towards the viewer counts this part of motion in the picture.
constexpr double kTowards = 0.5;

/// The cube around the moving vertices, where they were and where they are: the same for all
/// directions.
struct Surroundings {
    Point center{0, 0, 0};
    double radius = 0;
};

Surroundings surroundings_of(std::span<const Point> reference, std::span<const Point> moved,
                             const std::vector<int>& moving) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Point low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    for (const int v : moving) {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min({low[k], reference[at(v)][k], moved[at(v)][k]});
            high[k] = std::max({high[k], reference[at(v)][k], moved[at(v)][k]});
        }
    }
    Surroundings around;
    for (std::size_t k = 0; k < 3; ++k) around.center[k] = low[k] + 0.5 * (high[k] - low[k]);
    for (const int v : moving) {
        around.radius = std::max({around.radius, square_distance(around.center, reference[at(v)]),
                                  square_distance(around.center, moved[at(v)])});
    }
    around.radius = std::sqrt(around.radius);
    return around;
}

/// 1 or -1 where the corners of faces seen from outside go round counterclockwise or clockwise, 0
/// where the mesh has no inside to speak of: what is open to one side has none.
int outside_of(const TriangleMesh& mesh) {
    const Point center = centroid(mesh.vertices);
    double volume = 0, area = 0;
    Point open{0, 0, 0};
    for (const Face& face : mesh.faces) {
        const Point a = minus(mesh.vertices[at(face[0])], center);
        const Point b = minus(mesh.vertices[at(face[1])], center);
        const Point c = minus(mesh.vertices[at(face[2])], center);
        const Point normal = cross(minus(b, a), minus(c, a));
        for (std::size_t k = 0; k < 3; ++k) open[k] += normal[k] / 2;
        volume += dot(a, cross(b, c)) / 6;
        area += std::hypot(normal[0], normal[1], normal[2]) / 2;
    }
    constexpr double kSome = 0.01;  // of area^1.5; a ball has 0.094
    constexpr double kOpenSide = 0.3;
    if (std::hypot(open[0], open[1], open[2]) > kOpenSide * area) return 0;
    if (!(std::abs(volume) > kSome * area * std::sqrt(area))) return 0;
    return volume > 0 ? 1 : -1;
}

/// The nearest face at each sample.
struct FaceGrid {
    std::vector<double> depth = std::vector<double>(static_cast<std::size_t>(kGrid) * kGrid,
                                                    -std::numeric_limits<double>::infinity());
    std::vector<int> face = std::vector<int>(static_cast<std::size_t>(kGrid) * kGrid, -1);

    /// Corners in samples, depth towards the viewer.
    void draw(int number, const Point& a, const Point& b, const Point& c) {
        const auto [left, right] = std::minmax({a[0], b[0], c[0]});
        const auto [bottom, top] = std::minmax({a[1], b[1], c[1]});
        if (right < 0 || top < 0 || left > kGrid || bottom > kGrid) return;
        const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (!(std::abs(area) > 0)) return;
        const int x0 = static_cast<int>(std::max(0.0, std::ceil(left - 0.5)));
        const int y0 = static_cast<int>(std::max(0.0, std::ceil(bottom - 0.5)));
        const int x1 = static_cast<int>(std::min(kGrid - 1.0, std::floor(right - 0.5)));
        const int y1 = static_cast<int>(std::min(kGrid - 1.0, std::floor(top - 0.5)));
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) {
                const double px = x + 0.5 - a[0], py = y + 0.5 - a[1];
                const double of_b = (px * (c[1] - a[1]) - py * (c[0] - a[0])) / area;
                const double of_c = ((b[0] - a[0]) * py - (b[1] - a[1]) * px) / area;
                if (of_b < 0 || of_c < 0 || of_b + of_c > 1) continue;
                const double z = a[2] + of_b * (b[2] - a[2]) + of_c * (c[2] - a[2]);
                const auto place = at(y * kGrid + x);
                if (z <= depth[place]) continue;
                depth[place] = z;
                face[place] = number;
            }
        }
    }
};

}  // namespace

double visible_motion(const TriangleMesh& reference, std::span<const Point> moved,
                      const Motion& motion, const std::array<Point, 3>& axes) {
    if (motion.moving.empty()) return 0;
    const Surroundings around = surroundings_of(reference.vertices, moved, motion.moving);
    const double scale = kGrid / (2 * around.radius);
    std::vector<Point> seen(moved.size());
    for (std::size_t v = 0; v < moved.size(); ++v) {
        const Point offset = minus(moved[v], around.center);
        seen[v] = {0.5 * kGrid + scale * dot(offset, axes[0]),
                   0.5 * kGrid + scale * dot(offset, axes[1]), dot(offset, axes[2])};
    }
    FaceGrid grid;
    for (std::size_t f = 0; f < reference.faces.size(); ++f) {
        const Face& face = reference.faces[f];
        grid.draw(static_cast<int>(f), seen[at(face[0])], seen[at(face[1])], seen[at(face[2])]);
    }
    const int outside = outside_of(reference);
    double sum = 0;
    const double least = kMovingShare * motion.largest;
    for (const int f : grid.face) {
        if (f < 0) continue;
        const Face& face = reference.faces[at(f)];
        const Point &a = seen[at(face[0])], &b = seen[at(face[1])], &c = seen[at(face[2])];
        const double turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (turn * outside < 0) continue;
        Point move{0, 0, 0};
        for (const int v : face) {
            if (motion.amount[at(v)] < least) continue;
            const Point way = minus(moved[at(v)], reference.vertices[at(v)]);
            for (std::size_t k = 0; k < 3; ++k) move[k] += way[k] / 3;
        }
        const double in_picture = std::hypot(dot(move, axes[0]), dot(move, axes[1]));
        const double whole = std::hypot(move[0], move[1], move[2]);
        sum += kTowards * whole + (1 - kTowards) * in_picture;
    }
    return sum / (scale * scale);
}

}  // namespace mscomp
