// SPDX-License-Identifier: MIT
#include "polar.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;

void expect_rotation_and_symmetric(const PolarDecomposition& polar, const Matrix3d& gradient) {
    const Matrix3d& r = polar.rotation;
    EXPECT_LT(largest(r.transpose() * r - Matrix3d::Identity()), 1e-14);
    EXPECT_NEAR(r.determinant(), 1, 1e-14);
    EXPECT_EQ(polar.stretch, polar.stretch.transpose());
    EXPECT_LT(largest(r * polar.stretch - gradient), 1e-13 * (1 + gradient.norm()));
}

// R = U Vᵀ, S = V Σ Vᵀ of the singular value decomposition.
TEST(Polar, AgreesWithTheSingularValueDecomposition) {
    Draws draws(1);
    int seen = 0;
    for (int trial = 0; trial < 400; ++trial) {
        const Matrix3d gradient = draws.matrix();
        if (gradient.determinant() <= 0) continue;
        ++seen;
        const Eigen::JacobiSVD<Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const PolarDecomposition polar = polar_decomposition(gradient);
        EXPECT_FALSE(polar.mirrored);
        expect_rotation_and_symmetric(polar, gradient);
        const double gap = svd.singularValues()[2];
        EXPECT_LT(largest(polar.rotation - svd.matrixU() * svd.matrixV().transpose()), 1e-14 / gap);
    }
    EXPECT_GT(seen, 100);
}

// det T < 0: the smallest singular direction, and only that, is flipped.
TEST(Polar, MirroredMapFlipsTheSmallestSingularDirection) {
    const Matrix3d frame = rotation_about({1, 2, 3}, 0.9);
    const Matrix3d turn = rotation_about({-1, 0.3, 1}, 2.0);
    const Vector3d stretches(3, 2, -0.5);
    const Matrix3d stretch = frame * stretches.asDiagonal() * frame.transpose();
    const PolarDecomposition polar = polar_decomposition(turn * stretch);
    EXPECT_TRUE(polar.mirrored);
    expect_rotation_and_symmetric(polar, turn * stretch);
    EXPECT_LT(largest(polar.rotation - turn), 1e-14);
    EXPECT_LT(largest(polar.stretch - stretch), 1e-14);
}

TEST(Polar, SingularMapsAreFiniteAndProper) {
    const Matrix3d turn = rotation_about({0, 1, 1}, 1.0);
    for (const Vector3d& stretches : {Vector3d(2, 1, 0), Vector3d(1, 0, 0), Vector3d(1, 1e-9, 0),
                                      Vector3d(1, 1e-5, 1e-10), Vector3d(0, 0, 0)}) {
        const Matrix3d gradient = turn * stretches.asDiagonal();
        const PolarDecomposition polar = polar_decomposition(gradient);
        expect_rotation_and_symmetric(polar, gradient);
    }
}

// T -> a T leaves R and scales S.
TEST(Polar, RotationDoesNotDependOnTheUnit) {
    Draws draws(2);
    const Matrix3d gradient = Matrix3d::Identity() + 0.4 * draws.matrix();
    const PolarDecomposition one = polar_decomposition(gradient);
    for (const double unit : {1e-100, 1e-8, 1e8, 1e100}) {
        const PolarDecomposition scaled = polar_decomposition(unit * gradient);
        EXPECT_LT(largest(scaled.rotation - one.rotation), 1e-14);
        EXPECT_LT(largest(scaled.stretch / unit - one.stretch), 1e-14);
    }
}

}  // namespace
}  // namespace mscomp
