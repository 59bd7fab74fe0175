// SPDX-License-Identifier: MIT
#include "reduced_normal_equations.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "acap/acap_cases.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Columns of the six infinitesimal rigid motions of the points, (3V,6).
MatrixXd rigid_columns(const std::vector<Point>& points) {
    MatrixXd columns(static_cast<Eigen::Index>(3 * points.size()), 6);
    for (Eigen::Index i = 0; i < columns.rows() / 3; ++i) {
        const cases::Vector3d p = cases::vec(points[static_cast<std::size_t>(i)]);
        for (int axis = 0; axis < 3; ++axis) {
            const cases::Vector3d e = cases::Vector3d::Unit(axis);
            columns.block<3, 1>(3 * i, axis) = e;
            columns.block<3, 1>(3 * i, 3 + axis) = e.cross(p);
        }
    }
    return columns;
}

// Elimination of the motion is projection onto what no motion can do.
void expect_projection(const std::vector<Point>& points) {
    const auto rows = static_cast<Eigen::Index>(3 * points.size());
    cases::Draws draws(8);
    MatrixXd J(rows, 4);
    for (Eigen::Index k = 0; k < 4; ++k) {
        for (Eigen::Index i = 0; i < rows; ++i) J(i, k) = draws.next();
    }
    VectorXd r(rows);
    for (Eigen::Index i = 0; i < rows; ++i) r[i] = draws.next();
    const MatrixXd motions = rigid_columns(points);
    const MatrixXd projected = J - motions * motions.completeOrthogonalDecomposition().solve(J);
    r -= motions * motions.completeOrthogonalDecomposition().solve(r);
    std::vector<Point> residuals(points.size());
    Eigen::Map<VectorXd>(residuals.front().data(), rows) = r;
    const NormalEquations found = reduced_normal_equations(
        std::span<const double>(J.data(), static_cast<std::size_t>(J.size())), points, residuals);
    EXPECT_LT(cases::largest(found.H - projected.transpose() * projected), 1e-10);
    EXPECT_LT(cases::largest(found.g - projected.transpose() * r), 1e-10);
}

TEST(ReducedNormalEquations, ProjectRigidMotionsOut) {
    TriangleMesh mesh = cases::bumpy_sphere(1);
    for (Point& p : mesh.vertices) p[0] += 3;  // away from the origin
    expect_projection(mesh.vertices);
}

// A straight line cannot be seen to turn about itself, a point not at all.
TEST(ReducedNormalEquations, KnowMotionsThatDoNothing) {
    std::vector<Point> line;
    for (int i = 0; i < 9; ++i) line.push_back({0.5 * i, 1.0, -0.25 * i});
    expect_projection(line);
    expect_projection(std::vector<Point>(7, Point{1, 2, 3}));
}

// With one of the motions as derivative there is nothing left to gain by it.
TEST(ReducedNormalEquations, SeeNothingInARigidMotion) {
    const TriangleMesh mesh = cases::bumpy_sphere(1);
    const MatrixXd motions = rigid_columns(mesh.vertices);
    const NormalEquations found = reduced_normal_equations(
        std::span<const double>(motions.data(), static_cast<std::size_t>(motions.size())),
        mesh.vertices, std::vector<Point>(mesh.vertices.size(), Point{}));
    EXPECT_LT(cases::largest(found.H), 1e-11);
}

}  // namespace
}  // namespace mscomp
