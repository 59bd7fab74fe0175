// SPDX-License-Identifier: MIT
// Meshes, features and directions for what is derived by features.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "acap_cases.h"
#include "mscomp/acap/reconstruct.h"

namespace mscomp::cases {

/// Two spheres and a vertex without faces beside each: the last hangs on what hangs on the first.
inline TriangleMesh several_parts() {
    TriangleMesh mesh = shapes::beside(bumpy_sphere(1), shapes::icosphere(1), 7);
    mesh.vertices.push_back({1, 2, 3});
    mesh.vertices.push_back({9, 0.5, 0});
    return mesh;
}

inline std::vector<TriangleMesh> small_meshes() {
    return {bumpy_sphere(2), shapes::grid(6, 5), several_parts()};
}

/// A multiple of 2^-8: sums with multiples of it by small powers of two are exact in float.
inline float dyadic(double x) { return static_cast<float>(std::round(256 * x) / 256); }

/// Random rotation vectors up to several turns, every third 0, and random stretches.
inline std::vector<float> some_features(const TriangleMesh& mesh, std::uint64_t stream) {
    Draws draws(stream);
    std::vector<float> features;
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        const double size = i % 3 == 0 ? 0 : i % 3 == 1 ? 0.25 : 6;
        for (int c = 0; c < 3; ++c) features.push_back(dyadic(size * draws.next()));
        for (int c = 3; c < kFeatureDim; ++c) {
            features.push_back(dyadic((c == 3 || c == 6 || c == 8 ? 1 : 0) + 0.4 * draws.next()));
        }
    }
    return features;
}

struct Direction {
    std::vector<int> vertices;
    std::vector<float> values;

    FeatureDirection view() const { return {vertices, values}; }
};

/// One dense direction, one of a single vertex, one of none, sparse ones.
inline std::vector<Direction> some_directions(const TriangleMesh& mesh, int count) {
    Draws draws(5);
    std::vector<Direction> directions(at(count));
    for (int k = 0; k < count; ++k) {
        for (int i = 0; i < mesh.vertex_count(); ++i) {
            const bool in = k == 0 || (k == 1 ? i == 4 : k > 2 && (i * 7 + k) % 5 == 0);
            if (!in) continue;
            directions[at(k)].vertices.push_back(i);
            for (int c = 0; c < kFeatureDim; ++c) {
                directions[at(k)].values.push_back(dyadic(draws.next()));
            }
        }
    }
    return directions;
}

inline std::vector<float> plus(std::vector<float> features, float x, const Direction& direction) {
    for (std::size_t n = 0; n < direction.vertices.size(); ++n) {
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            features[at(direction.vertices[n]) * kFeatureDim + c] +=
                x * direction.values[n * kFeatureDim + c];
        }
    }
    return features;
}

inline std::vector<FeatureDirection> views(const std::vector<Direction>& directions) {
    std::vector<FeatureDirection> result;
    for (const Direction& direction : directions) result.push_back(direction.view());
    return result;
}

}  // namespace mscomp::cases
