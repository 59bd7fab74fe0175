// SPDX-License-Identifier: MIT
// A bar twisted by several turns. Around an inner vertex the twisted mesh is symmetric under the
// half turn about its radius; hence its rotation is Rz(φ) times a rotation about that radius (the
// shear of the surface), and its turn about the axis is exactly φ.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cstdio>

#include "acap/deformation_gradient.h"
#include "acap/polar.h"
#include "acap/turns/consistency.h"
#include "mscomp/generate/generate.h"
#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;
constexpr double kPi = std::numbers::pi;
constexpr double kLength = 10;
constexpr int kAround = 12, kRings = 24;

/// Angle about z of a rotation vector, turns included: the twist of s -> exp(s r), followed from 0.
double turned_about_z(const Vector3d& r) {
    const double half = r.norm() / 2;
    if (!(half > 0)) return 0;
    const double turns = std::round(half / kPi);
    const double part = half - turns * kPi;
    const double tilt = r.z() / r.norm();
    const double angle =
        2 * std::atan2(std::abs(tilt) * std::sin(part), std::cos(part)) + 2 * kPi * turns;
    return tilt < 0 ? -angle : angle;
}

struct Bar {
    double turns;
    TriangleMesh reference = shapes::cylinder(kAround, kRings, 0.05, kLength, true);
    TriangleMesh shape = twisted(reference, turns, kLength);

    double angle(int vertex) const {
        return 2 * kPi * turns * reference.vertices[at(vertex)][2] / kLength;
    }
    bool on_end_ring(int vertex) const {
        return vertex < kAround || (vertex >= kAround * (kRings - 1) && vertex < kAround * kRings);
    }
};

class TwistedBar : public testing::TestWithParam<double> {};

TEST_P(TwistedBar, TurnsAboutItsAxisByTheExactAngleWithTheRightNumberOfTurns) {
    const Bar bar{GetParam()};
    const FeatureSet set = extract_one(bar.reference, bar.shape);
    for (int i = 0; i < bar.reference.vertex_count(); ++i) {
        const double turned = turned_about_z(rotation_vector(set, i));
        // The stencil of an end ring looks to one side only: it sees part of the next ring's turn.
        const double tolerance = bar.on_end_ring(i) ? 0.02 + 0.03 * bar.turns : 4e-6;
        ASSERT_NEAR(turned, bar.angle(i), tolerance) << "vertex " << i;
    }
}

// The centres of the caps turn rigidly: exact feature, although R = I after a full turn.
TEST_P(TwistedBar, CapCentersTurnRigidly) {
    const Bar bar{GetParam()};
    const FeatureSet set = extract_one(bar.reference, bar.shape);
    const int bottom = kAround * kRings;
    for (const int center : {bottom, bottom + 1}) {
        EXPECT_LT(largest(rotation_vector(set, center) - Vector3d(0, 0, bar.angle(center))), 4e-6);
        EXPECT_LT(largest(stretch(set, center) - Matrix3d::Identity()), 1e-6);
    }
}

TEST_P(TwistedBar, EnergyIsProvedLeastAndNotAboveThePrincipalLogarithms) {
    const Bar bar{GetParam()};
    const FeatureSet set = extract_one(bar.reference, bar.shape);
    EXPECT_NEAR(set.consistency_gap[0], 0, 1e-9 * set.consistency_energy[0]);
}

// By the symmetry, rings at the same distance from the middle carry the same stretch.
TEST_P(TwistedBar, StretchIsTheSameOnAllInnerRings) {
    const Bar bar{GetParam()};
    const FeatureSet set = extract_one(bar.reference, bar.shape);
    const Vector3d first = stretch(set, kAround).selfadjointView<Eigen::Lower>().eigenvalues();
    for (int i = kAround; i < kAround * (kRings - 1); ++i) {
        const Vector3d here = stretch(set, i).selfadjointView<Eigen::Lower>().eigenvalues();
        ASSERT_LT(largest(here - first), 1e-5) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Turns, TwistedBar, testing::Values(0.5, 1.0, 2.5));

// A thick bar shears so much that beyond a full turn no branch is continuous; the rotation itself
// is exact all the same.
TEST(ThickTwistedBar, EveryInnerVertexTurnsByTheExactAngle) {
    const TriangleMesh reference = shapes::cylinder(16, 21, 1, kLength, true);
    for (const double turns : {0.5, 1.0, 2.5}) {
        const FeatureSet set = extract_one(reference, twisted(reference, turns, kLength));
        for (int i = 16; i < 16 * 20; ++i) {
            const Eigen::Quaterniond q(exp_of(rotation_vector(set, i)));
            const double turned = 2 * std::atan2(q.z(), q.w());
            const double wanted = 2 * kPi * turns * reference.vertices[at(i)][2] / kLength;
            ASSERT_NEAR(std::remainder(turned - wanted, 2 * kPi), 0, 4e-6) << "vertex " << i;
        }
    }
}

struct TwistCase {
    double turns, tilt, noise, thickness;
};

/// The turns of the last frames of a generated bar, whose rotations are known.
class KnownTurns : public testing::TestWithParam<TwistCase> {
  protected:
    static constexpr int kFrames = 9;

    KnownTurns() {
        const TwistCase& c = GetParam();
        bar_ = generate_twist(kFrames, 3, 400, {c.turns, c.tilt, c.noise, c.thickness});
        const MeshSequence& sequence = bar_.sequence;
        const TriangleMesh reference{sequence.shapes.front(), sequence.faces};
        const DeformationGradients gradients(reference, EdgeWeights::cotangent);
        std::vector<double> unrest(reference.vertices.size(), 0.0);
        for (const std::vector<Point>& shape : sequence.shapes) {
            Field logs;
            for (const Matrix3d& gradient : gradients.compute(shape).gradients) {
                logs.push_back(rotation_log(polar_decomposition(gradient).rotation));
                unrest[logs.size() - 1] += logs.back().norm();
            }
            logs_.push_back(std::move(logs));
        }
        graph_ = consistency_graph(gradients.rings(), unrest);
    }

    Field truth(int frame) const {
        Field r(logs_.front().size());
        const float* v = bar_.rotation_truth.rotation.data() + at(frame) * r.size() * 3;
        for (std::size_t i = 0; i < r.size(); ++i) r[i] = {v[3 * i], v[3 * i + 1], v[3 * i + 2]};
        return r;
    }
    /// Share of the vertices whose result is on the branch nearest to the truth.
    double recovered(const Field& result, const TurnProblem& problem, const Field& true_r) const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < result.size(); ++i) {
            const auto vertex = static_cast<int>(i);
            const int wanted = problem.nearest_turn(vertex, true_r[i]);
            const Vector3d nearest = problem.rotation_vector(vertex, wanted);
            if ((nearest - result[i]).norm() < 1e-3) ++count;
        }
        return static_cast<double>(count) / static_cast<double>(result.size());
    }

    GeneratedSequence bar_;
    ConsistencyGraph graph_;
    std::vector<Field> logs_;
};

// Whatever the noise and the tilt: the result has no more energy than the true turns.
TEST_P(KnownTurns, ResultIsNotAboveTheTrueTurnsInEnergy) {
    double share = 0, least_share = 1;
    int proved = 0;
    for (int frame = 1; frame < kFrames; ++frame) {
        const Field true_r = truth(frame);
        const TurnProblem problem(graph_, logs_[at(frame)]);
        TurnProblem::Turns true_turns;
        for (int i = 0; i < problem.vertex_count(); ++i) {
            true_turns.push_back(problem.nearest_turn(i, true_r[at(i)]));
        }
        Field r = logs_[at(frame)];
        const ConsistencySummary summary = make_consistent(graph_, r);
        EXPECT_LE(summary.energy, problem.energy(true_turns) + 1e-9) << "frame " << frame;
        EXPECT_LE(summary.lower_bound, problem.energy(true_turns) + 1e-9) << "frame " << frame;
        const bool is_proved = summary.energy - summary.lower_bound < 1e-6;
        proved += is_proved ? 1 : 0;
        // Proved least, so no other start can be better.
        if (is_proved) {
            ConsistencySummary again = summary;
            EXPECT_FALSE(improve_consistency(graph_, true_r, r, again));
        }
        const double here = recovered(r, problem, true_r);
        share += here / (kFrames - 1);
        least_share = std::min(least_share, here);
    }
    const TwistCase& c = GetParam();
    std::printf("| %g | %g | %g | %g | %.1f | %.1f | %d of %d |\n", c.turns, c.tilt, c.noise,
                c.thickness, 100 * share, 100 * least_share, proved, kFrames - 1);
}

std::vector<TwistCase> twist_cases() {
    std::vector<TwistCase> cases;
    for (const double turns : {0.5, 1.5, 2.5, 5.0}) {
        for (const double tilt : {0.0, 20.0}) {
            for (const double noise : {0.0, 0.02, 0.1}) cases.push_back({turns, tilt, noise, 0.05});
        }
    }
    cases.push_back({2.5, 0, 0, 1.52});
    return cases;
}
INSTANTIATE_TEST_SUITE_P(Bars, KnownTurns, testing::ValuesIn(twist_cases()));

}  // namespace
}  // namespace mscomp
