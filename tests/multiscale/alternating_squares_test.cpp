// SPDX-License-Identifier: MIT
#include "multiscale/alternating_squares.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "ball_cases.h"
#include "mscomp/base/parallel.h"
#include "multiscale/joint_codes.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

struct Rounds {
    cases::Sphere sphere;
    OneRings rings = one_rings_of_faces(sphere.vertices(), sphere.mesh.faces);

    double round(const MetricRows& rows, double damping, BallComponents& components) const {
        return AlternatingSquares(rings, sphere.scale, damping).round(rows, components);
    }
};

// Against dense algebra, vertex by vertex.
TEST(AlternatingSquares, SolveTheEquationsOfTheHeader) {
    Rounds rounds;
    constexpr int kCount = 15;
    constexpr double kDamping = 0.05;
    BallComponents components = rounds.sphere.components(kCount, 0.35);
    const MatrixXd before = cases::dense(components);
    const MatrixXd shapes = cases::random_matrix(before.rows(), 8, 1).cast<float>().cast<double>();
    const MetricRows rows = cases::rows_of(shapes);
    const MatrixXd z = JointCodes(components).solve(products(components, rows));
    const double error = rounds.round(rows, kDamping, components);
    EXPECT_NEAR(error, (shapes - before * z).squaredNorm() / 8, 1e-6 * error);

    const MatrixXd gram = z * z.transpose();
    const double mu = kDamping * gram.trace() / kCount;
    MatrixXd wanted = MatrixXd::Zero(before.rows(), kCount);
    for (int v = 0; v < rounds.sphere.vertices(); ++v) {
        const auto acting = components.at_vertex(v);
        const auto count = static_cast<Eigen::Index>(acting.size());
        MatrixXd matrix(count, count), right(count, 9);
        for (Eigen::Index a = 0; a < count; ++a) {
            const int k = acting[at(a)];
            right.row(a) = z.row(k) * shapes.middleRows<9>(9 * v).transpose();
            MatrixXd mean = MatrixXd::Zero(9, 1);
            const int first = rounds.rings.offsets[at(v)], last = rounds.rings.offsets[at(v) + 1];
            for (int entry = first; entry < last; ++entry) {
                const int u = rounds.rings.neighbors[at(entry)];
                mean += before.col(k).segment<9>(9 * u) / rounds.sphere.scale.root(at(u)) /
                        (last - first);
            }
            right.row(a) += mu * rounds.sphere.scale.root(at(v)) * mean.transpose();
            for (Eigen::Index b = 0; b < count; ++b) {
                matrix(a, b) = gram(k, acting[at(b)]) + (a == b ? mu : 0);
            }
        }
        const MatrixXd solved = matrix.fullPivLu().solve(right);
        for (Eigen::Index a = 0; a < count; ++a) {
            wanted.col(acting[at(a)]).segment<9>(9 * v) = solved.row(a).transpose();
        }
    }
    for (int k = 0; k < kCount; ++k) wanted.col(k).normalize();
    EXPECT_LT((cases::dense(components) - wanted).norm(), 1e-5);
}

// Each half of a round minimises the same sum of squares: it never rises. Shapes that are sums of
// such components come back.
TEST(AlternatingSquares, LowerTheErrorInEveryRound) {
    Rounds rounds;
    const BallComponents truth = rounds.sphere.components(8, 0.3);
    const MetricRows rows = cases::rows_of(cases::dense(truth) * cases::random_matrix(8, 40, 3));
    BallComponents components = truth;
    const CounterRandom random(8, 1);
    for (std::size_t i = 0; i < components.all_values().size(); ++i) {
        components.all_values()[i] += static_cast<float>(0.05 * random.normal(i));
    }
    double before = rounds.round(rows, 0, components);
    const double first = before;
    for (int round = 0; round < 40; ++round) {
        const double error = rounds.round(rows, 0, components);
        EXPECT_LE(error, before * (1 + 1e-6)) << round;
        before = error;
    }
    EXPECT_LT(before, 1e-4 * first);
}

// Fewer shapes than components at a vertex: what they leave open is as at the neighbours, so that a
// smooth deformation has smooth components, and nothing is infinite.
TEST(AlternatingSquares, WhatIsOpenIsSmooth) {
    Rounds rounds;
    MatrixXd shapes(9 * rounds.sphere.vertices(), 2);
    for (int v = 0; v < rounds.sphere.vertices(); ++v) {
        const Point& p = rounds.sphere.mesh.vertices[at(v)];
        for (int c = 0; c < 9; ++c) {
            shapes(9 * v + c, 0) = std::sin(p[0] + c);
            shapes(9 * v + c, 1) = std::cos(2 * p[1] + c);
        }
    }
    const MetricRows rows = cases::rows_of(shapes);
    BallComponents components = rounds.sphere.components(20, 0.45);
    const auto roughness = [&] {
        const MatrixXd C = cases::dense(components);
        double sum = 0;
        for (int k = 0; k < components.count(); ++k) {
            for (const int v : components.balls()[at(k)].vertices) {
                const int u = rounds.rings.neighbors[at(rounds.rings.offsets[at(v)])];
                sum += (C.col(k).segment<9>(9 * v) - C.col(k).segment<9>(9 * u)).squaredNorm();
            }
        }
        return sum;
    };
    const double at_first = roughness();
    for (int round = 0; round < 40; ++round) rounds.round(rows, 0.01, components);
    EXPECT_TRUE(cases::dense(components).allFinite());
    EXPECT_LT(roughness(), 0.25 * at_first);
}

TEST(AlternatingSquares, WhatIsZeroStaysZero) {
    Rounds rounds;
    BallComponents components = rounds.sphere.components(4, 0.3);
    std::ranges::fill(components.all_values(), 0.0F);
    const MetricRows rows = cases::rows_of(MatrixXd::Zero(9 * rounds.sphere.vertices(), 3));
    EXPECT_EQ(rounds.round(rows, 0.01, components), 0);
    for (const float x : components.all_values()) EXPECT_EQ(x, 0.0F);
}

TEST(AlternatingSquares, ThreadsDoNotChangeABit) {
    Rounds rounds;
    const MetricRows rows =
        cases::rows_of(cases::random_matrix(9 * rounds.sphere.vertices(), 5, 1));
    const auto result = [&](int threads) {
        set_thread_count(threads);
        BallComponents components = rounds.sphere.components(20, 0.35);
        rounds.round(rows, 0.01, components);
        set_thread_count(0);
        return cases::dense(components);
    };
    const MatrixXd wanted = result(1);
    for (const int threads : {2, 7}) EXPECT_TRUE(result(threads) == wanted);
}

}  // namespace
}  // namespace mscomp
