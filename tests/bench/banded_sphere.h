// SPDX-License-Identifier: MIT
// Unit spheres of any number of vertices, as the training step is timed on them, and the exact
// distances on them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/random.h"

namespace mscomp {

/// Vertices on the circles of latitude between the poles, their distance along a circle about that
/// between circles: sums to V - 2.
inline std::vector<int> vertices_on_circles(int vertex_count) {
    const double edge = std::sqrt(8 * std::numbers::pi / (std::sqrt(3.0) * vertex_count));
    const int circles = static_cast<int>(std::numbers::pi / (edge * std::sqrt(0.75)) + 0.5) - 1;
    double whole = 0;
    for (int i = 1; i <= circles; ++i) whole += std::sin(std::numbers::pi * i / (circles + 1));
    std::vector<int> counts;
    double sum = 0;
    int used = 0;
    for (int i = 1; i <= circles; ++i) {
        sum += std::sin(std::numbers::pi * i / (circles + 1)) / whole;
        const int until = static_cast<int>(std::lround(sum * (vertex_count - 2)));
        counts.push_back(until - used);
        used = until;
    }
    return counts;
}

/// A closed triangulation of the unit sphere with exactly `vertex_count` >= 100 vertices, mean
/// degree 6 - 12 / V: circles of latitude sewn together. Vertices are in random order, as those of
/// a scanner's file may be.
inline TriangleMesh banded_sphere(int vertex_count) {
    const std::vector<int> counts = vertices_on_circles(vertex_count);
    const std::vector<int> place = CounterRandom(1, 2).permutation(vertex_count);
    TriangleMesh mesh;
    mesh.vertices.resize(static_cast<std::size_t>(vertex_count));
    const auto at = [&](int index) { return place[static_cast<std::size_t>(index)]; };
    const auto put = [&](int index, const Point& p) {
        mesh.vertices[static_cast<std::size_t>(at(index))] = p;
    };
    const int circles = static_cast<int>(counts.size()), last = vertex_count - 1;
    put(0, {0, 0, 1});
    put(last, {0, 0, -1});
    int above = 0, above_count = 1, first = 1;
    for (int i = 0; i <= circles; ++i) {
        const int count = i < circles ? counts[static_cast<std::size_t>(i)] : 1;
        const double polar = std::numbers::pi * (i + 1) / (circles + 1);
        for (int j = 0; j < count && i < circles; ++j) {
            const double around = 2 * std::numbers::pi * j / count;
            put(first + j, {std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                            std::cos(polar)});
        }
        // Sews the two circles: the one whose next vertex comes first goes on. A pole stays.
        const int up_steps = above_count > 1 ? above_count : 0, down_steps = count > 1 ? count : 0;
        for (int a = 0, b = 0; a < up_steps || b < down_steps;) {
            const int up = at(above + a % above_count), down = at(first + b % count);
            const bool along_upper =
                b == down_steps || (a < up_steps && (a + 1) * static_cast<double>(count) <
                                                        (b + 1) * static_cast<double>(above_count));
            const int next = along_upper ? at(above + ++a % above_count) : at(first + ++b % count);
            mesh.faces.push_back({up, down, next});
        }
        above = first;
        above_count = count;
        first += count;
    }
    return mesh;
}

/// Great-circle distances on the unit sphere, divided by pi; rows are kept.
class SphereRows final : public DistanceRows {
  public:
    explicit SphereRows(std::vector<Point> points) : points_(std::move(points)) {}
    int vertex_count() const override { return static_cast<int>(points_.size()); }
    std::span<const double> row(int vertex) override {
        std::vector<double>& row = rows_[vertex];
        if (row.empty()) {
            const Point& p = points_[static_cast<std::size_t>(vertex)];
            for (const Point& q : points_) {
                const double cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
                row.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) / std::numbers::pi);
            }
        }
        return row;
    }

  private:
    std::vector<Point> points_;
    std::unordered_map<int, std::vector<double>> rows_;
};

}  // namespace mscomp
