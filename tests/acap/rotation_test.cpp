// SPDX-License-Identifier: MIT
#include "acap/rotation.h"

#include <gtest/gtest.h>

#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;

TEST(Rotation, ExpOfLogIsTheRotation) {
    Draws draws(1);
    for (int trial = 0; trial < 200; ++trial) {
        const Matrix3d rotation = draws.rotation();
        EXPECT_LT(largest(rotation_exp(rotation_log(rotation)) - rotation), 1e-14);
    }
}

// log exp r = r for every |r| < π.
TEST(Rotation, LogOfExpIsTheVectorDownToTinyAnglesAndUpToPi) {
    Draws draws(2);
    for (const double angle :
         {1e-300, 1e-20, 1e-12, 1e-8, 1e-5, 0.1, 3.0, kPi - 1e-5, kPi - 1e-9}) {
        const Vector3d r = draws.vector().normalized() * angle;
        const Vector3d back = rotation_log(rotation_exp(r));
        EXPECT_LT(largest(back - r), 1e-15 + 4e-15 * angle) << angle;
    }
}

TEST(Rotation, IdentityHasLogarithmZero) {
    EXPECT_EQ(rotation_log(Matrix3d::Identity()), Vector3d::Zero());
    EXPECT_EQ(rotation_exp(Vector3d::Zero()), Matrix3d::Identity());
}

// A rotation by π is I - 2 (I - ω ωᵀ), built here without any angle.
TEST(Rotation, HalfTurnGivesItsAxisUpToSign) {
    Draws draws(3);
    std::vector<Vector3d> axes{Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
    for (int trial = 0; trial < 50; ++trial) axes.push_back(draws.vector().normalized());
    for (const Vector3d& axis : axes) {
        const Matrix3d half_turn = 2 * axis * axis.transpose() - Matrix3d::Identity();
        const Vector3d r = rotation_log(half_turn);
        EXPECT_NEAR(r.norm(), kPi, 1e-14);
        EXPECT_LT(largest(r / kPi * (r / kPi).transpose() - axis * axis.transpose()), 1e-14);
    }
}

TEST(Rotation, ExpOfSeveralTurnsIsExpOfTheRest) {
    const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
    EXPECT_LT(largest(rotation_exp(axis * (0.7 + 6 * kPi)) - rotation_about(axis, 0.7)), 1e-14);
}

TEST(Rotation, GradientOfFeatureIsRotationTimesStretch) {
    const Feature f{{0.5, 0, 0, 1, 2, 3, 4, 5, 6}};
    Matrix3d s;
    s << 1, 2, 3, 2, 4, 5, 3, 5, 6;
    EXPECT_LT(largest(gradient_of_feature(f) - rotation_about(Vector3d::UnitX(), 0.5) * s), 1e-14);
}

}  // namespace
}  // namespace mscomp
