// SPDX-License-Identifier: MIT
#include "acap/polar.h"

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

/// Every kind of matrix that T can be, neighbours of one kind never alike.
std::vector<Matrix3d> all_kinds_of_matrices() {
    Draws draws(3);
    std::vector<Matrix3d> all;
    for (int n = 0; n < 30; ++n) {
        const Matrix3d regular = draws.rotation() * (Matrix3d::Identity() + 0.2 * draws.matrix());
        const Matrix3d turn = draws.rotation(), frame = draws.rotation();
        const auto stretched = [&](double x, double y, double z) -> Matrix3d {
            return turn * frame * Vector3d(x, y, z).asDiagonal() * frame.transpose();
        };
        for (const Matrix3d& matrix :
             {regular, Matrix3d(draws.matrix()), stretched(1, 0.5, 1e-9), stretched(2, 1, -0.7),
              Matrix3d(Matrix3d::Zero()), stretched(3, 0, 0), Matrix3d(1e290 * regular),
              Matrix3d(1e-290 * regular), Matrix3d(1e-306 * regular), Matrix3d(1e307 * regular),
              stretched(30, 1, 0.05), stretched(1, 1, 1)}) {
            all.push_back(matrix);
        }
    }
    return all;
}

bool is_same(const PolarDecomposition& a, const PolarDecomposition& b) {
    return a.rotation == b.rotation && a.stretch == b.stretch && a.mirrored == b.mirrored;
}

// Bit for bit, whatever stands beside it, and for any number of matrices.
TEST(Polar, ManyAtATimeAreWhatEachIsAlone) {
    const std::vector<Matrix3d> all = all_kinds_of_matrices();
    for (const std::size_t count : {0UL, 1UL, 2UL, 7UL, 8UL, 15UL, 16UL, 17UL, 33UL, all.size()}) {
        PolarDecomposition untouched;
        untouched.rotation.setConstant(5);
        std::vector<PolarDecomposition> results(count + 1, untouched);
        polar_decompositions(all, std::span(results).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            EXPECT_TRUE(is_same(results[i], polar_decomposition(all[i]))) << i << " of " << count;
        }
        EXPECT_EQ(results[count].rotation, untouched.rotation);
    }
}

// R = U Vᵀ where that has a determinant of 1; elsewhere R is still a proper rotation and R S = T.
TEST(Polar, ManyAtATimeAgreeWithTheSingularValueDecomposition) {
    const std::vector<Matrix3d> all = all_kinds_of_matrices();
    std::vector<PolarDecomposition> results(all.size());
    polar_decompositions(all, results);
    int well_conditioned = 0, mirrored = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const double size = all[i].cwiseAbs().maxCoeff() > 0 ? all[i].cwiseAbs().maxCoeff() : 1;
        const Matrix3d scaled = all[i] / size;
        PolarDecomposition polar = results[i];
        polar.stretch /= size;
        expect_rotation_and_symmetric(polar, scaled);
        const Eigen::JacobiSVD<Matrix3d> svd(scaled, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const double least = svd.singularValues()[2];
        const Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
        const bool is_proper = nearest.determinant() > 0;
        if (least > 1e-8) {
            EXPECT_EQ(polar.mirrored, !is_proper) << i;
            mirrored += polar.mirrored ? 1 : 0;
        }
        if (!(is_proper && least > 0.05)) continue;
        ++well_conditioned;
        EXPECT_LE(largest(polar.rotation - nearest), 1e-13) << i;
        EXPECT_LE(largest(polar.stretch - nearest.transpose() * scaled), 1e-13) << i;
    }
    EXPECT_GT(well_conditioned, 150);
    EXPECT_GT(mirrored, 30);
}

}  // namespace
}  // namespace mscomp
