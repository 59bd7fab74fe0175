// SPDX-License-Identifier: MIT
// The twisted bar: that its closed form is what extraction finds, where it is said to hold.
#include <gtest/gtest.h>

#include <algorithm>

#include "acap/acap_cases.h"
#include "generated_cases.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace cases;
constexpr double kPi = std::numbers::pi;
constexpr double kLength = 10;

Vector3d true_rotation(const GeneratedSequence& g, int frame, int vertex) {
    const auto row = at(frame) * at(g.sequence.vertex_count()) + at(vertex);
    return Eigen::Map<const Eigen::Vector3f>(g.rotation_truth.rotation.data() + 3 * row)
        .cast<double>();
}

const float* true_feature(const GeneratedSequence& g, int frame, int vertex) {
    return g.rotation_truth.features.data() +
           (at(frame) * at(g.sequence.vertex_count()) + at(vertex)) * kFeatureDim;
}

Vector3d vector_of(const float* feature) { return {feature[0], feature[1], feature[2]}; }

TwistOptions turned_by(double turns) {
    TwistOptions options;
    options.turns = turns;
    return options;
}

FeatureSet features_of(const GeneratedSequence& g) {
    return extract_features(g.sequence, g.sequence.shapes[0], {EdgeWeights::cotangent, false});
}

TEST(Twist, IsAClosedSurfaceTurnedOutwards) {
    const GeneratedSequence bar = generate_twist(2);
    EXPECT_TRUE(is_oriented_manifold(bar.sequence.faces));
    EXPECT_EQ(boundary_edges(bar.sequence.faces), 0);
    EXPECT_EQ(euler_characteristic(bar.sequence), 2);
    EXPECT_GT(volume(bar.sequence.shapes[0], bar.sequence.faces), 0);
    EXPECT_GE(bar.sequence.vertex_count(), 400);
    EXPECT_LE(bar.sequence.vertex_count(), 408);
}

// All triangles but those of the two caps are congruent.
TEST(Twist, IsMadeOfEqualTriangles) {
    const GeneratedSequence bar = generate_twist(2);
    const std::vector<double> sizes = areas(bar.sequence.shapes[0], bar.sequence.faces);
    for (std::size_t f = 8; f + 8 < sizes.size(); ++f) {
        ASSERT_NEAR(sizes[f], sizes[8], 1e-12 * kLength * kLength);
    }
    TwistOptions thick;
    thick.thickness = 1.52;
    const GeneratedSequence even = generate_twist(2, 0, 1000, thick);
    const std::vector<double> lengths = edge_lengths(even.sequence.shapes[0], even.sequence.faces);
    for (std::size_t e = 24; e + 24 < lengths.size(); ++e) {
        ASSERT_NEAR(lengths[e] / lengths[24], 1, 0.01);
    }
}

// p -> rotation by 2 pi turns z/L about the axis, the amount growing linearly frame by frame.
TEST(Twist, TurnsEveryPointByTheExactAngleAtAnyResolution) {
    for (const int vertices : {300, 1000}) {
        const GeneratedSequence bar = generate_twist(11, 0, vertices, turned_by(5));
        for (int n = 0; n < 11; ++n) {
            for (int i = 0; i < bar.sequence.vertex_count(); ++i) {
                const Vector3d rest = vec(bar.sequence.shapes[0][at(i)]);
                const double angle = 2 * kPi * 5 * rest.z() / kLength * n / 10;
                const Vector3d wanted = rotation_about(Vector3d::UnitZ(), angle) * rest;
                ASSERT_LT(largest(vec(bar.sequence.shapes[at(n)][at(i)]) - wanted), 1e-10);
                ASSERT_LT(largest(true_rotation(bar, n, i) - Vector3d(0, 0, angle)), 2e-6);
            }
        }
    }
}

// Rotation matrices and stretches need no choice of turns: exact on every frame.
TEST(Twist, ExtractsToTheRotationAndStretchOfTheClosedForm) {
    for (const double turns : {0.5, -3.0, 5.0}) {
        const GeneratedSequence bar = generate_twist(7, 0, 400, turned_by(turns));
        const FeatureSet set = features_of(bar);
        int compared = 0;
        for (int n = 0; n < 7; ++n) {
            for (int i = 0; i < bar.sequence.vertex_count(); ++i) {
                if (!bar.rotation_truth.exact[at(i)]) continue;
                const float* wanted = true_feature(bar, n, i);
                ASSERT_LT(largest(exp_of(rotation_vector(set, i, n)) - exp_of(vector_of(wanted))),
                          1e-5)
                    << "frame " << n << ", vertex " << i;
                for (int c = 3; c < kFeatureDim; ++c) {
                    ASSERT_NEAR(feature(set, i, n)[c], wanted[c], 2e-6) << c;
                }
                ++compared;
            }
        }
        EXPECT_EQ(compared, 7 * (bar.sequence.vertex_count() - 16));
    }
}

/// Whether some ring is so near to a full turn, in steps from ring to ring, that going on through
/// it is not the least energy.
bool has_ring_at_full_turn(const GeneratedSequence& g, int frame) {
    const double step = true_rotation(g, frame, 12).norm();  // of ring 1
    for (int i = 0; i < g.sequence.vertex_count(); ++i) {
        const double angle = true_rotation(g, frame, i).norm();
        if (angle > kPi && std::abs(std::remainder(angle, 2 * kPi)) < 0.15 * step) return true;
    }
    return false;
}

// Five turns, every turn counted.
TEST(Twist, ExtractsToTheRotationVectorsOfTheClosedFormTurnsIncluded) {
    const GeneratedSequence bar = generate_twist(31, 0, 400, turned_by(5));
    const FeatureSet set = features_of(bar);
    int compared = 0;
    for (int n = 0; n < 31; ++n) {
        if (has_ring_at_full_turn(bar, n)) continue;
        ++compared;
        double worst = 0;
        for (int i = 0; i < bar.sequence.vertex_count(); ++i) {
            if (!bar.rotation_truth.exact[at(i)]) continue;
            const Vector3d off = rotation_vector(set, i, n) - vector_of(true_feature(bar, n, i));
            worst = std::max(worst, largest(off));
        }
        EXPECT_TRUE(worst <= 1e-4) << "frame " << n << ": " << worst;
    }
    EXPECT_GE(compared, 14);
}

// A tilted axis: rings stay rigid and are turned by exp(rotation), steps along the middle line keep
// their length.
TEST(Twist, CarriesRingsRigidlyAboutATiltedAxis) {
    TwistOptions options = turned_by(4);
    options.tilt = 30;
    const GeneratedSequence bar = generate_twist(9, 0, 600, options);
    EXPECT_TRUE(bar.rotation_truth.features.empty());
    const int V = bar.sequence.vertex_count();
    const auto center = [&](int frame, int ring) {
        Vector3d sum = Vector3d::Zero();
        for (int k = 0; k < 8; ++k)
            sum += vec(bar.sequence.shapes[at(frame)][at(8 * ring + k)]) / 8;
        return sum;
    };
    const double step = (center(0, 1) - center(0, 0)).norm();
    for (int n = 0; n < 9; ++n) {
        for (int i = 0; i + 2 < V; ++i) {
            const Vector3d rest = vec(bar.sequence.shapes[0][at(i)]) - center(0, i / 8);
            const Vector3d moved = vec(bar.sequence.shapes[at(n)][at(i)]) - center(n, i / 8);
            ASSERT_LT(largest(exp_of(true_rotation(bar, n, i)) * rest - moved), 1e-6);
        }
        for (int ring = 1; ring < (V - 2) / 8; ++ring) {
            ASSERT_NEAR((center(n, ring) - center(n, ring - 1)).norm() / step, 1, 0.02);
        }
    }
    const Vector3d axis = true_rotation(bar, 8, V - 1).normalized();
    const Vector3d first = true_rotation(bar, 8, 8).normalized();
    EXPECT_NEAR(std::acos(axis.dot(first)) * 180 / kPi, 30, 0.6);
}

// Turned by the truth, away from full turns, every turn is found about a tilted axis as well.
TEST(Twist, ExtractsToTheTrueTurnsAboutATiltedAxis) {
    TwistOptions options = turned_by(5);
    options.tilt = 30;
    const GeneratedSequence bar = generate_twist(31, 0, 400, options);
    const FeatureSet set = features_of(bar);
    int compared = 0;
    for (int n = 0; n < 31; ++n) {
        if (has_ring_at_full_turn(bar, n)) continue;
        ++compared;
        for (int i = 0; i < bar.sequence.vertex_count(); ++i) {
            const Vector3d r = rotation_vector(set, i, n), wanted = true_rotation(bar, n, i);
            if (r.norm() == 0) continue;
            const double turns = std::round((wanted.dot(r) / r.norm() - r.norm()) / (2 * kPi));
            ASSERT_EQ(turns, 0) << "frame " << n << ", vertex " << i;
        }
    }
    EXPECT_GE(compared, 14);
}

// Standard deviation relative to the mean edge length, frame 0 spared, another seed another noise.
TEST(Twist, AddsTheNoiseAskedFor) {
    TwistOptions noisy;
    noisy.noise = 0.05;
    const GeneratedSequence clean = generate_twist(5), first = generate_twist(5, 0, 400, noisy),
                            second = generate_twist(5, 1, 400, noisy);
    EXPECT_EQ(first.sequence.shapes[0], clean.sequence.shapes[0]);
    EXPECT_NE(first.sequence.shapes[1], second.sequence.shapes[1]);
    EXPECT_EQ(first.rotation_truth.features, clean.rotation_truth.features);
    const double edge = mean(edge_lengths(clean.sequence.shapes[0], clean.sequence.faces));
    double sum = 0, square = 0, count = 0;
    for (std::size_t n = 1; n < 5; ++n) {
        for (std::size_t i = 0; i < clean.sequence.shapes[n].size(); ++i) {
            const Point off = minus(first.sequence.shapes[n][i], clean.sequence.shapes[n][i]);
            sum += off[0] + off[1] + off[2];
            square += dot(off, off);
            count += 3;
        }
    }
    EXPECT_NEAR(std::sqrt(square / count) / edge, 0.05, 0.003);
    EXPECT_NEAR(sum / count / edge, 0, 0.003);
}

TEST(Twist, RefusesWhatItCannotTurn) {
    EXPECT_THROW(generate_twist(1), UsageError);
    EXPECT_THROW(generate_twist(60, 0, 99), UsageError);
    EXPECT_THROW(generate_twist(60, 0, 100, turned_by(6.1)), UsageError);  // 13 rings
    EXPECT_NO_THROW(generate_twist(2, 0, 100, turned_by(5.9)));
    EXPECT_THROW(generate_twist(60, 0, 400, turned_by(std::nan(""))), UsageError);
    TwistOptions options;
    options.noise = -0.1;
    EXPECT_THROW(generate_twist(60, 0, 400, options), UsageError);
}

}  // namespace
}  // namespace mscomp
