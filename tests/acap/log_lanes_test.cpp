// SPDX-License-Identifier: MIT
#include "acap/log_lanes.h"

#include <gtest/gtest.h>

#include <array>

#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;

/// The logarithms of some rotations, `kLanes` at most.
std::vector<Vector3d> logs(const std::vector<Matrix3d>& rotations) {
    LogLanes lanes;
    for (std::size_t lane = 0; lane < LogLanes::kLanes; ++lane) {
        const Matrix3d& rotation = rotations[lane % rotations.size()];
        for (int k = 0; k < 9; ++k) lanes.rotation[k][lane] = rotation.data()[k];
    }
    rotation_logs(lanes);
    std::vector<Vector3d> result;
    for (std::size_t lane = 0; lane < rotations.size(); ++lane) {
        result.emplace_back(lanes.logarithm[0][lane], lanes.logarithm[1][lane],
                            lanes.logarithm[2][lane]);
    }
    return result;
}

// log exp(θ ω) = θ ω for θ < π, with an error relative to θ; every sixteenth of a turn and the
// bounds between the ways to compute it are met.
TEST(LogLanes, IsTheInverseOfTheExponential) {
    Draws draws(9);
    for (int n = 0; n < 400; ++n) {
        const Vector3d axis = draws.vector().normalized();
        for (const double angle : {1e-12, 1e-7, 1e-3, 0.3, std::numbers::pi / 4 - 1e-9, 0.8, 1.5708,
                                   2.2, 2.3562, 3.0, 3.14, 3.1415926}) {
            // Through the quaternion, as a matrix of an angle below 1e-8 needs it.
            const Matrix3d rotation = rotation_about(axis, angle);
            const Vector3d r = logs({rotation})[0];
            ASSERT_LT(largest(r - angle * axis), 4e-16 * (1 + angle)) << angle;
            ASSERT_LT(largest(r / angle - axis), std::max(1e-15, 3e-16 / angle)) << angle;
        }
    }
}

// Each of the four largest components of the quaternion, and all zeros in the others.
TEST(LogLanes, HalfTurnsAndTheIdentityAreExact) {
    EXPECT_EQ(logs({Matrix3d::Identity()})[0], Vector3d::Zero());
    for (int k = 0; k < 3; ++k) {
        const Vector3d axis = Vector3d::Unit(k);
        const Matrix3d half_turn = 2 * axis * axis.transpose() - Matrix3d::Identity();
        EXPECT_LT(largest(logs({half_turn})[0].cwiseAbs() - std::numbers::pi * axis), 5e-16);
    }
}

// At π the sign of the axis is free, its line is not.
TEST(LogLanes, HalfTurnsKeepTheirLine) {
    Draws draws(10);
    for (int n = 0; n < 200; ++n) {
        const Vector3d axis = draws.vector().normalized();
        const Matrix3d half_turn = 2 * axis * axis.transpose() - Matrix3d::Identity();
        const Vector3d r = logs({half_turn})[0];
        ASSERT_LT(largest(r * (r.dot(axis) < 0 ? -1 : 1) - std::numbers::pi * axis), 4e-15);
    }
}

// Every lane is what it is in any other place.
TEST(LogLanes, LanesDoNotDependOnEachOther) {
    Draws draws(11);
    std::vector<Matrix3d> rotations;
    for (int n = 0; n < LogLanes::kLanes; ++n) rotations.push_back(draws.rotation());
    const std::vector<Vector3d> together = logs(rotations);
    for (std::size_t n = 0; n < rotations.size(); ++n) {
        EXPECT_EQ(logs({rotations[n]})[0], together[n]);
    }
}

}  // namespace
}  // namespace mscomp
