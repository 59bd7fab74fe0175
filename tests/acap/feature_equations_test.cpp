// SPDX-License-Identifier: MIT
#include "acap/reconstruct/feature_equations.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "acap/reconstruct/ring_residual.h"
#include "acap/reconstruct/tangential_solve.h"
#include "acap/rotation.h"
#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;

struct Problem {
    TriangleMesh reference;
    std::vector<Point> shape;
    FeatureEquations equations;
    std::vector<Matrix3d> wanted;

    /// Features of `target`, looked at from `from`.
    Problem(const TriangleMesh& mesh, const TriangleMesh& target, const TriangleMesh& from)
        : reference(mesh), shape(from.vertices), equations(mesh, EdgeWeights::cotangent) {
        wanted = equations.wanted(equations.gradients().compute(target.vertices).gradients);
    }
    double energy(const std::vector<Point>& at_shape) const {
        std::vector<Point> unused;
        return equations.energy(at_shape, wanted, unused);
    }
};

std::vector<Problem> problems() {
    const TriangleMesh ball = bumpy_sphere(1), sheet = shapes::grid(4, 3);
    const auto lifted = [](const Vector3d& p) -> Vector3d {
        return {p.x(), p.y() + 0.1 * p.x(), 0.2 * p.x() * p.y()};
    };
    std::vector<Problem> result;
    result.emplace_back(ball, ball, mapped(ball, wobble));
    result.emplace_back(sheet, sheet, mapped(sheet, lifted));
    return result;
}

// E = Σ_i |(T'_i - T_i) M_i^½|², written with the gradients of extraction.
TEST(FeatureEquations, EnergyIsTheDistanceOfTheGradientsInTheMetricOfTheMoments) {
    for (const Problem& problem : problems()) {
        const DeformationGradients& gradients = problem.equations.gradients();
        const auto now = gradients.compute(problem.shape).gradients;
        const auto before = gradients.compute(problem.reference.vertices).gradients;
        double sum = 0;
        for (std::size_t i = 0; i < now.size(); ++i) {
            const Matrix3d moment = gradients.inverse_moments()[i].inverse();
            const Matrix3d difference = now[i] - before[i];
            sum += (difference * moment * difference.transpose()).trace();
        }
        EXPECT_NEAR(problem.energy(problem.shape), sum, 1e-9 * sum);
    }
}

// Against 4-point differences, in the direction of every coordinate.
TEST(FeatureEquations, DerivativeIsThatOfTheEnergy) {
    for (const Problem& problem : problems()) {
        std::vector<Point> derivative;
        problem.equations.energy(problem.shape, problem.wanted, derivative);
        double scale = 0;
        for (const Point& p : derivative) scale = std::max(scale, vec(p).norm());
        for (std::size_t i = 0; i < problem.shape.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto moved_by = [&](double step) {
                    std::vector<Point> shape = problem.shape;
                    shape[i][axis] += step;
                    return problem.energy(shape);
                };
                const double h = 1e-4;
                const double slope =
                    (8 * (moved_by(h) - moved_by(-h)) - (moved_by(2 * h) - moved_by(-2 * h))) /
                    (12 * h);
                EXPECT_LE(std::abs(derivative[i][axis] - slope), 1e-8 * scale)
                    << "vertex " << i << ", axis " << axis;
            }
        }
    }
}

/// Σ |r_i|² of the residuals given to Ceres, and twice Jᵀ r.
double ring_squares(const Problem& problem, std::vector<Point>& slope) {
    const std::vector<RingShape> rings = ring_shapes(problem.equations);
    slope.assign(problem.shape.size(), Point{});
    double squares = 0;
    for (std::size_t i = 0; i < rings.size(); ++i) {
        const RingResidual residual(rings[i], problem.wanted[i]);
        const std::size_t count = rings[i].members.size();
        std::vector<const double*> positions;
        std::vector<std::array<double, 27>> jacobians(count);
        std::vector<double*> rows;
        for (std::size_t k = 0; k < count; ++k) {
            positions.push_back(problem.shape[at(rings[i].members[k])].data());
            rows.push_back(jacobians[k].data());
        }
        std::array<double, 9> r{};
        EXPECT_TRUE(residual.Evaluate(positions.data(), r.data(), rows.data()));
        for (std::size_t e = 0; e < 9; ++e) {
            squares += r[e] * r[e];
            for (std::size_t k = 0; k < count; ++k) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    slope[at(rings[i].members[k])][axis] += 2 * jacobians[k][3 * e + axis] * r[e];
                }
            }
        }
    }
    return squares;
}

TEST(FeatureEquations, RingResidualsAndTheirJacobiansMakeEnergyAndDerivative) {
    for (const Problem& problem : problems()) {
        std::vector<Point> derivative, slope;
        const double energy = problem.equations.energy(problem.shape, problem.wanted, derivative);
        EXPECT_NEAR(ring_squares(problem, slope), energy, 1e-10 * energy);
        for (std::size_t i = 0; i < slope.size(); ++i) {
            EXPECT_LE((vec(slope[i]) - vec(derivative[i])).norm(), 1e-9 * std::sqrt(energy));
        }
    }
}

// Folded flat along its middle, the normals of the rings there cancel: both ways of writing the
// equations must choose the same of the two directions, whichever way the sheet is turned.
TEST(FeatureEquations, RingResidualsAgreeOnFoldedRings) {
    const TriangleMesh sheet = shapes::grid(7, 5);
    const double middle = sheet.vertices[at(sheet.vertex_count() / 2)][0];
    const TriangleMesh flat = mapped(sheet, [&](const Vector3d& p) -> Vector3d {
        return {middle + std::abs(p.x() - middle), p.y(), 0};
    });
    for (const double angle : {0.3, 1.7, 3.1, 4.4}) {
        const Matrix3d turn = rotation_about({1, 2, 0.5}, angle);
        const auto turned = [&](const Vector3d& p) -> Vector3d { return turn * p; };
        const Problem problem(sheet, sheet, mapped(flat, turned));
        ASSERT_GT(problem.equations.gradients().pseudo_edges(problem.shape).folded_rings.count, 2);
        std::vector<Point> derivative, slope;
        const double energy = problem.equations.energy(problem.shape, problem.wanted, derivative);
        EXPECT_NEAR(ring_squares(problem, slope), energy, 1e-10 * energy);
    }
}

// A mesh fulfils the linear part of the equations of its features: from anywhere, one solve finds
// it.
TEST(TangentialSolve, FindsTheMeshOfItsGradientsFromAnywhere) {
    for (const Problem& problem : problems()) {
        const TangentialSolve solve(problem.equations, {0});
        std::vector<Point> found(problem.shape.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            found[i] = point(vec(problem.shape[i]) + Vector3d::Constant(0.1 * std::sin(7.0 * i)));
        }
        solve.apply(problem.wanted, found);
        const Vector3d shift = vec(problem.reference.vertices[0]) - vec(found[0]);
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_LE((vec(found[i]) + shift - vec(problem.reference.vertices[i])).norm(), 1e-9);
        }
    }
}

// Without the pseudo-edge: r_i P_i does not change when only the pseudo-edge does.
TEST(FeatureEquations, TangentialPartDoesNotSeeThePseudoEdge) {
    for (const Problem& problem : problems()) {
        for (std::size_t i = 0; i < problem.shape.size(); ++i) {
            const Vector3d seen =
                problem.equations.tangential()[i] * problem.equations.normal_factors()[i];
            EXPECT_LE(seen.norm(), 1e-12 * problem.equations.normal_factors()[i].norm());
            EXPECT_NEAR(problem.equations.tangential()[i].trace(), 2, 1e-12);
        }
    }
}

}  // namespace
}  // namespace mscomp
