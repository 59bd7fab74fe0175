// SPDX-License-Identifier: MIT
#include "edit/reduced_normal_equations.h"

#include <gtest/gtest.h>

#include "acap/acap_cases.h"
#include "dense.h"

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
    const MatrixXd projected = cases::unexplained(motions, J);
    r = cases::unexplained(motions, r);
    std::vector<Point> residuals(points.size());
    Eigen::Map<VectorXd>(residuals.front().data(), rows) = r;
    const NormalEquations found = reduced_normal_equations(
        std::span<const double>(J.data(), static_cast<std::size_t>(J.size())), points, residuals);
    EXPECT_LT(cases::largest(found.H - cases::inner_products(projected, projected)), 1e-10);
    EXPECT_LT(cases::largest(found.g - cases::inner_products(projected, r)), 1e-10);
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

/// H, g and |r|² of random residuals in five codes, the last two of which do the same if `twins`.
struct SmallCase {
    NormalEquations equations;
    double squares;
};

SmallCase small_case(bool twins) {
    cases::Draws draws(11);
    MatrixXd J(40, 5);
    VectorXd r(40);
    for (Eigen::Index i = 0; i < 40; ++i) {
        for (Eigen::Index k = 0; k < 5; ++k) J(i, k) = draws.next();
        r[i] = draws.next();
    }
    if (twins) J.col(4) = J.col(3);
    return {{cases::inner_products(J, J), cases::inner_products(J, r)}, r.squaredNorm()};
}

// K + 1 residuals stand for forty: the same sum of squares, gradient and normal matrix, singular
// ones included, and the last does not depend on the codes.
TEST(SmallResiduals, HaveSquaresGradientAndMatrixOfAll) {
    for (const bool twins : {false, true}) {
        const auto [equations, squares] = small_case(twins);
        const SmallResiduals found = small_residuals(equations, squares);
        const MatrixXd& R = found.derivative;
        ASSERT_EQ(found.values.size(), 6);
        EXPECT_NEAR(found.values.squaredNorm(), squares, 1e-12 * squares);
        EXPECT_LT(cases::largest(cases::inner_products(R, found.values) - equations.g), 1e-12);
        EXPECT_LT(cases::largest(cases::inner_products(R, R) - equations.H), 1e-12);
        EXPECT_EQ(R.row(5).norm(), 0);
        EXPECT_GT(found.values[5], 0);
    }
}

// Codes that do nothing leave the sum of squares alone.
TEST(SmallResiduals, OfCodesThatDoNothingAreTheLastAlone) {
    const SmallResiduals found = small_residuals({MatrixXd::Zero(3, 3), VectorXd::Zero(3)}, 4.0);
    EXPECT_EQ(found.values, (VectorXd(4) << 0, 0, 0, 2).finished());
    EXPECT_EQ(found.derivative.norm(), 0);
}

}  // namespace
}  // namespace mscomp
