// SPDX-License-Identifier: MIT
// What the tests of the generated sequences share: measures of meshes and access to the truth.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mscomp/generate/generate.h"

namespace mscomp::cases {

inline Point minus(const Point& p, const Point& q) {
    return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}
inline Point cross(const Point& u, const Point& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
inline double dot(const Point& u, const Point& v) {
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}
inline double norm(const Point& u) { return std::sqrt(dot(u, u)); }

inline double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

// -------------------------------------------------------------------------------------------
// Connectivity.

/// How often each directed edge occurs.
inline std::map<std::array<int, 2>, int> sides_of(const std::vector<Face>& faces) {
    std::map<std::array<int, 2>, int> sides;
    for (const Face& f : faces) {
        for (std::size_t k = 0; k < 3; ++k) ++sides[{f[k], f[(k + 1) % 3]}];
    }
    return sides;
}

/// Every edge at most once in each direction.
inline bool is_oriented_manifold(const std::vector<Face>& faces) {
    const auto sides = sides_of(faces);
    return std::ranges::all_of(sides, [](const auto& side) { return side.second == 1; });
}

inline int boundary_edges(const std::vector<Face>& faces) {
    const auto sides = sides_of(faces);
    return static_cast<int>(std::ranges::count_if(sides, [&](const auto& side) {
        return !sides.contains({side.first[1], side.first[0]});
    }));
}

/// V - E + F, with the vertices that some face has.
inline int euler_characteristic(const MeshSequence& sequence) {
    std::set<std::array<int, 2>> edges;
    std::set<int> used;
    for (const auto& [side, count] : sides_of(sequence.faces)) {
        edges.insert({std::min(side[0], side[1]), std::max(side[0], side[1])});
        used.insert(side[0]);
    }
    EXPECT_EQ(static_cast<int>(used.size()), sequence.vertex_count());
    return static_cast<int>(used.size()) - static_cast<int>(edges.size()) +
           static_cast<int>(sequence.faces.size());
}

// -------------------------------------------------------------------------------------------
// Measures.

/// Twice the area times the unit normal of a face.
inline Point face_normal(const std::vector<Point>& points, const Face& f) {
    const Point& p = points[static_cast<std::size_t>(f[0])];
    return cross(minus(points[static_cast<std::size_t>(f[1])], p),
                 minus(points[static_cast<std::size_t>(f[2])], p));
}

/// Least cosine between the normals of two faces that share an edge; below 0 the surface folds
/// over.
inline double least_fold_cosine(const std::vector<Point>& points, const std::vector<Face>& faces) {
    std::map<std::array<int, 2>, std::size_t> face_of;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) face_of[{faces[f][k], faces[f][(k + 1) % 3]}] = f;
    }
    double least = 1;
    for (const auto& [side, f] : face_of) {
        const auto other = face_of.find({side[1], side[0]});
        if (other == face_of.end()) continue;
        const Point a = face_normal(points, faces[f]);
        const Point b = face_normal(points, faces[other->second]);
        const double cosine = dot(a, b) / (norm(a) * norm(b));
        if (!(cosine >= least)) least = cosine;
    }
    return least;
}

/// (F) areas of the faces.
inline std::vector<double> areas(const std::vector<Point>& points, const std::vector<Face>& faces) {
    std::vector<double> result;
    for (const Face& f : faces) result.push_back(norm(face_normal(points, f)) / 2);
    return result;
}

/// (3 F) lengths of the edges, face by face.
inline std::vector<double> edge_lengths(const std::vector<Point>& points,
                                        const std::vector<Face>& faces) {
    std::vector<double> result;
    for (const Face& f : faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            result.push_back(norm(minus(points[static_cast<std::size_t>(f[k])],
                                        points[static_cast<std::size_t>(f[(k + 1) % 3])])));
        }
    }
    return result;
}

/// Volume by the divergence theorem, positive if the faces are turned outwards.
inline double volume(const std::vector<Point>& points, const std::vector<Face>& faces) {
    double sum = 0;
    for (const Face& f : faces) {
        sum += dot(points[static_cast<std::size_t>(f[0])], face_normal(points, f)) / 6;
    }
    return sum;
}

// -------------------------------------------------------------------------------------------
// The truth.

inline float weight(const GeneratedSequence& g, int frame, int component) {
    return g.weights[static_cast<std::size_t>(frame * g.component_count() + component)];
}

inline float support(const GeneratedSequence& g, int component, int vertex) {
    return g.supports[static_cast<std::size_t>(component) *
                          static_cast<std::size_t>(g.sequence.vertex_count()) +
                      static_cast<std::size_t>(vertex)];
}

inline int component_named(const GeneratedSequence& g, const std::string& name) {
    const auto at = std::ranges::find(g.component_names, name);
    return static_cast<int>(at - g.component_names.begin());
}

/// Share of the vertices that a component reaches.
inline double support_share(const GeneratedSequence& g, int component) {
    int reached = 0;
    for (int i = 0; i < g.sequence.vertex_count(); ++i) reached += support(g, component, i) > 0;
    return static_cast<double>(reached) / g.sequence.vertex_count();
}

/// Largest Pearson correlation, in absolute value, of two components over the frames after the
/// first; infinite if a component hardly moves.
inline double largest_correlation(const GeneratedSequence& g) {
    const int N = g.sequence.shape_count() - 1;
    std::vector<std::vector<double>> rows;
    for (int k = 0; k < g.component_count(); ++k) {
        std::vector<double> values;
        for (int n = 1; n <= N; ++n) values.push_back(static_cast<double>(weight(g, n, k)));
        const double middle = mean(values);
        double square = 0;
        for (double& value : values) square += (value - middle) * (value - middle);
        if (!(square / N > 0.05)) return std::numeric_limits<double>::infinity();
        for (double& value : values) value = (value - middle) / std::sqrt(square);
        rows.push_back(std::move(values));
    }
    double worst = 0;
    for (std::size_t k = 0; k < rows.size(); ++k) {
        for (std::size_t l = 0; l < k; ++l) {
            double sum = 0;
            for (std::size_t n = 0; n < rows[k].size(); ++n) sum += rows[k][n] * rows[l][n];
            worst = std::max(worst, std::abs(sum));
        }
    }
    return worst;
}

inline double highest_support(const GeneratedSequence& g, int component) {
    float highest = 0;
    for (int i = 0; i < g.sequence.vertex_count(); ++i) {
        const float value = support(g, component, i);
        EXPECT_TRUE(value >= 0 && value <= 1);
        highest = std::max(highest, value);
    }
    return static_cast<double>(highest);
}

/// Vertex of another resolution that stands at (nearly) the same place at rest; the distance goes
/// to `off`.
inline int nearest_vertex(const GeneratedSequence& g, const Point& place, double& off) {
    int nearest = 0;
    off = std::numeric_limits<double>::infinity();
    for (int i = 0; i < g.sequence.vertex_count(); ++i) {
        const double distance =
            norm(minus(g.sequence.shapes[0][static_cast<std::size_t>(i)], place));
        if (distance < off) {
            off = distance;
            nearest = i;
        }
    }
    return nearest;
}

}  // namespace mscomp::cases
