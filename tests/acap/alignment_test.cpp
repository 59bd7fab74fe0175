// SPDX-License-Identifier: MIT
#include "mscomp/acap/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;

double squared_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (vec(a[i]) - vec(b[i])).squaredNorm();
    return sum;
}

TEST(Alignment, UndoesARigidMotion) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const Matrix3d turn = rotation_about({1, 2, -1}, 2.5);
    const TriangleMesh shape =
        mapped(mesh, [&](const Vector3d& p) -> Vector3d { return turn * p + Vector3d(5, -3, 2); });
    const RigidMotion motion = best_rigid_motion(shape.vertices, mesh.vertices);
    EXPECT_LT(largest(motion.rotation - turn.transpose()), 1e-14);
    EXPECT_LT(squared_distance(moved(shape.vertices, motion), mesh.vertices), 1e-26);
}

// A minimum: every small further motion makes the distance larger.
TEST(Alignment, NoNearbyMotionIsBetter) {
    const TriangleMesh mesh = bumpy_sphere(1), shape = mapped(mesh, wobble);
    const RigidMotion best = best_rigid_motion(shape.vertices, mesh.vertices);
    const double least = squared_distance(moved(shape.vertices, best), mesh.vertices);
    for (int axis = 0; axis < 3; ++axis) {
        for (const double step : {-1e-3, 1e-3}) {
            RigidMotion turned = best, shifted = best;
            turned.rotation = rotation_about(Vector3d::Unit(axis), step) * best.rotation;
            shifted.translation[axis] += step;
            EXPECT_GT(squared_distance(moved(shape.vertices, turned), mesh.vertices), least);
            EXPECT_GT(squared_distance(moved(shape.vertices, shifted), mesh.vertices), least);
        }
    }
}

TEST(Alignment, NeverMirrors) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const TriangleMesh mirror =
        mapped(mesh, [](const Vector3d& p) -> Vector3d { return Vector3d(-p.x(), p.y(), p.z()); });
    const RigidMotion motion = best_rigid_motion(mirror.vertices, mesh.vertices);
    EXPECT_NEAR(motion.rotation.determinant(), 1, 1e-14);
    const TriangleMesh flat = shapes::grid(4, 3);
    const TriangleMesh turned = mapped(flat, [](const Vector3d& p) -> Vector3d {
        return rotation_about(Vector3d::UnitY(), 1.0) * p;
    });
    const RigidMotion back = best_rigid_motion(turned.vertices, flat.vertices);
    EXPECT_LT(largest(back.rotation - rotation_about(Vector3d::UnitY(), -1.0)), 1e-13);
}

}  // namespace
}  // namespace mscomp
