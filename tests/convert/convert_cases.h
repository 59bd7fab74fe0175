// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/feature_set.h"
#include "shapes.h"

namespace mscomp::cases {

/// `count` stretched spheres; positions no float32 has.
inline MeshSequence stretched_spheres(int count) {
    const TriangleMesh sphere = shapes::icosphere(1);
    MeshSequence sequence;
    sequence.faces = sphere.faces;
    for (int i = 0; i < count; ++i) {
        sequence.names.push_back("sphere \xc3\xa9 " + std::to_string(i));
        std::vector<Point> points = sphere.vertices;
        for (Point& point : points) point[2] *= 1 + 0.1 * i;
        sequence.shapes.push_back(std::move(points));
    }
    return sequence;
}

/// Two shapes of a tetrahedron, every number another one, with all that a feature set can hold.
inline FeatureSet full_set() {
    FeatureSet set;
    set.names = {"rest", "caf\xc3\xa9 \"2\""};
    for (int i = 0; i < 2 * 4 * kFeatureDim; ++i) {
        set.features.push_back(0.1F * static_cast<float>(i) - 2);
    }
    set.features[5] = -0.0F;
    for (int i = 0; i < 2 * 4 * 3; ++i) set.vertices.push_back(0.3F * static_cast<float>(i));
    set.reference.vertices = {{0, 0, 0}, {1, 0, 1.0 / 3}, {1, 1, 0}, {0, 1, 1e-300}};
    set.reference.faces = {{0, 1, 2}, {3, 0, 2}};
    set.rotation = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, -1, 0, 1, 0, 0, 0, 0, 1}};
    set.translation = {{0, 0, 0}, {0.1, -0.2, 7}};
    set.weights = "uniform";
    set.principal_energy = {0, 40};
    set.propagation_energy = {0, 20};
    set.relaxation_energy = {std::numeric_limits<double>::quiet_NaN(), 30};
    set.consistency_energy = {0, 19.75};
    set.consistency_gap = {0, 0.5};
    set.largest_jump = {0, 0.6};
    set.large_jumps = {0, 7};
    set.inherent_jumps = {0, 4};
    set.removable_jumps = {0, 1};
    set.warnings = {"2 vertices are in no face", "another"};
    return set;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

inline void expect_same(const FeatureSet& got, const FeatureSet& wanted) {
    EXPECT_EQ(got.names, wanted.names);
    EXPECT_TRUE(same_bits(got.features, wanted.features));
    EXPECT_TRUE(same_bits(got.vertices, wanted.vertices));
    EXPECT_TRUE(same_bits(got.reference.vertices, wanted.reference.vertices));
    EXPECT_EQ(got.reference.faces, wanted.reference.faces);
    EXPECT_TRUE(same_bits(got.rotation, wanted.rotation));
    EXPECT_TRUE(same_bits(got.translation, wanted.translation));
    EXPECT_EQ(got.weights, wanted.weights);
    EXPECT_TRUE(same_bits(got.principal_energy, wanted.principal_energy));
    EXPECT_TRUE(same_bits(got.propagation_energy, wanted.propagation_energy));
    EXPECT_TRUE(same_bits(got.relaxation_energy, wanted.relaxation_energy));
    EXPECT_TRUE(same_bits(got.consistency_energy, wanted.consistency_energy));
    EXPECT_TRUE(same_bits(got.consistency_gap, wanted.consistency_gap));
    EXPECT_TRUE(same_bits(got.largest_jump, wanted.largest_jump));
    EXPECT_TRUE(same_bits(got.large_jumps, wanted.large_jumps));
    EXPECT_TRUE(same_bits(got.inherent_jumps, wanted.inherent_jumps));
    EXPECT_TRUE(same_bits(got.removable_jumps, wanted.removable_jumps));
    EXPECT_EQ(got.warnings, wanted.warnings);
}

inline void expect_same(const ShapeSource& got, const MeshSequence& wanted) {
    EXPECT_EQ(got.faces(), wanted.faces);
    ASSERT_EQ(got.shape_count(), wanted.shape_count());
    ASSERT_EQ(got.vertex_count(), wanted.vertex_count());
    for (int i = 0; i < got.shape_count(); ++i) {
        EXPECT_TRUE(same_bits(got.shape(i), wanted.shapes[static_cast<std::size_t>(i)])) << i;
    }
}

}  // namespace mscomp::cases
