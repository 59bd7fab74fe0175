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

// A third of the shape moves, smoothly at its border: the rest comes to lie where it was, in any
// unit, which the best motion, spreading the change over all, does not do.
TEST(Alignment, WhatRestsLiesStill) {
    for (const double size : {1e-6, 1.0, 1e6}) {
        const TriangleMesh mesh =
            mapped(bumpy_sphere(2), [&](const Vector3d& p) -> Vector3d { return size * p; });
        const Matrix3d turn = rotation_about({1, 2, -1}, 0.4);
        const auto is_at_rest = [&](const Vector3d& p) { return p.y() < 0.4 * size; };
        const TriangleMesh shape = mapped(mesh, [&](const Vector3d& p) -> Vector3d {
            const double lift = is_at_rest(p) ? 0 : p.y() - 0.4 * size;
            return turn * (p + Vector3d(0, 0.2 * lift, 0.8 * lift)) + size * Vector3d(5, -3, 2);
        });
        const auto farthest_at_rest = [&](const RigidMotion& motion) {
            const std::vector<Point> placed = moved(shape.vertices, motion);
            double most = 0;
            for (std::size_t v = 0; v < placed.size(); ++v) {
                if (!is_at_rest(vec(mesh.vertices[v]))) continue;
                most = std::max(most, (vec(placed[v]) - vec(mesh.vertices[v])).norm() / size);
            }
            return most;
        };
        EXPECT_GT(farthest_at_rest(best_rigid_motion(shape.vertices, mesh.vertices)), 0.05);
        EXPECT_LT(farthest_at_rest(resting_motion(shape.vertices, mesh.vertices)), 1e-3);
    }
    const TriangleMesh mesh = bumpy_sphere(1);
    const RigidMotion none = resting_motion(mesh.vertices, mesh.vertices);
    EXPECT_LT(largest(none.rotation - Matrix3d::Identity()), 1e-14);
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
