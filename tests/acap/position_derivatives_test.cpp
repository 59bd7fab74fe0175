// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "acap/reconstruct/feature_equations.h"
#include "acap/reconstruct/tangential_solve.h"
#include "acap/rotation.h"
#include "acap_cases.h"
#include "derivative_cases.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

template <class Solver>
std::vector<double> derivatives_of(const Solver& solver, const std::vector<float>& features,
                                   const std::vector<Direction>& directions) {
    std::vector<double> result(directions.size() * features.size() / 3, 1e300);
    solver.derivatives(features, views(directions), result);
    return result;
}

Vector3d entry(const std::vector<double>& derivatives, std::size_t direction, std::size_t vertex,
               std::size_t vertex_count) {
    return Eigen::Map<const Vector3d>(derivatives.data() + 3 * (direction * vertex_count + vertex));
}

// exp(r + h d) exp(r)ᵀ = 1 + h [J_l(r) d]x + O(h²), on both sides of where the series ends.
TEST(RotationLeftJacobian, IsTheDerivativeOfTheExponential) {
    constexpr double h = 1e-3;
    Draws draws(3);
    for (const double angle : {0.0, 1e-9, 1e-3, 0.0999, 0.1001, 1.0, 3.14159265, 6.3, 20.0}) {
        const Vector3d r = angle * draws.vector().normalized(), d = draws.vector();
        const auto turned = [&](double x) -> Matrix3d {
            return rotation_exp(r + x * d) * rotation_exp(r).transpose();
        };
        const Matrix3d slope =
            (8 * (turned(h) - turned(-h)) - (turned(2 * h) - turned(-2 * h))) / (12 * h);
        const Vector3d turn(slope(2, 1), slope(0, 2), slope(1, 0));
        EXPECT_LT(largest(rotation_left_jacobian(r) * d - turn), 1e-10) << angle;
    }
}

// Features on a grid of 2^-15 are exact in float, so only the h⁴ of the differences is left.
TEST(PositionDerivatives, AreThoseOfPoisson) {
    constexpr float h = 1.0F / 128;
    for (const TriangleMesh& mesh : small_meshes()) {
        const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
        const std::vector<float> features = some_features(mesh, 1);
        const std::vector<Direction> directions = some_directions(mesh, 11);
        const std::vector<double> found = derivatives_of(poisson, features, directions);
        const std::size_t count = mesh.vertices.size();
        for (std::size_t k = 0; k < directions.size(); ++k) {
            const auto solved = [&](float x) {
                return poisson.solve(plus(features, x, directions[k]));
            };
            const auto a = solved(h), b = solved(-h), c = solved(2 * h), d = solved(-2 * h);
            double size = 0, error = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const Vector3d slope =
                    (8 * (vec(a[i]) - vec(b[i])) - (vec(c[i]) - vec(d[i]))) / (12 * double{h});
                size = std::max(size, largest(slope));
                error = std::max(error, largest(entry(found, k, i, count) - slope));
            }
            EXPECT_TRUE(error <= 1e-7 * size)
                << "direction " << k << ": " << error << " of " << size;
            EXPECT_EQ(size > 0, k != 2);
        }
    }
}

// The same T everywhere gives T p by either solver, whatever the weights: the derivative is dT p.
TEST(PositionDerivatives, OfTheSameChangeEverywhereAreThatLinearMap) {
    for (const TriangleMesh& mesh : {bumpy_sphere(2), shapes::cylinder(8, 5, 1, 3, false)}) {
        const Vector3d r(0.5, -1.25, 2), dr(0.25, 0.5, -1);
        Matrix3d s, ds;
        s << 1.5, 0.25, -0.125, 0.25, 0.75, 0.5, -0.125, 0.5, 1.25;
        ds << 0.5, -1, 0.25, -1, 2, 0, 0.25, 0, 1;
        std::vector<float> features;
        Direction direction;
        for (int i = 0; i < mesh.vertex_count(); ++i) {
            const auto add = [](const Vector3d& v, const Matrix3d& m, std::vector<float>& to) {
                for (const double x :
                     {v.x(), v.y(), v.z(), m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)}) {
                    to.push_back(static_cast<float>(x));
                }
            };
            add(r, s, features);
            direction.vertices.push_back(i);
            add(dr, ds, direction.values);
        }
        constexpr double h = 1e-3;
        const auto T = [&](double x) -> Matrix3d { return exp_of(r + x * dr) * (s + x * ds); };
        const Matrix3d dT = (8 * (T(h) - T(-h)) - (T(2 * h) - T(-2 * h))) / (12 * h);
        Vector3d center = Vector3d::Zero();
        for (const Point& p : mesh.vertices) center += vec(p) / mesh.vertex_count();
        const auto expect_linear = [&](const auto& solver, double tolerance) {
            const std::vector<double> found = derivatives_of(solver, features, {direction});
            for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
                const Vector3d wanted = dT * (vec(mesh.vertices[i]) - center);
                EXPECT_LT(largest(entry(found, 0, i, mesh.vertices.size()) - wanted), tolerance);
            }
        };
        expect_linear(PoissonReconstruction(mesh, EdgeWeights::cotangent), 1e-9);
        expect_linear(LosslessReconstruction(mesh, EdgeWeights::cotangent), 1e-4);
    }
}

// Where the features are those of no mesh the derivative of the lossless solver leaves its descent
// out, and the small share of the Laplacian that keeps its matrix definite in.
TEST(PositionDerivatives, AreThoseOfTheLinearPartOfLossless) {
    constexpr float h = 1.0F / 128;
    const TriangleMesh mesh = bumpy_sphere(2);
    const FeatureEquations equations(mesh, EdgeWeights::cotangent);
    const TangentialSolve tangential(equations, {0});
    const std::vector<float> features = some_features(mesh, 1);
    const std::vector<Direction> directions = some_directions(mesh, 5);
    const std::vector<double> found =
        derivatives_of(LosslessReconstruction(mesh, EdgeWeights::cotangent), features, directions);
    for (std::size_t k = 0; k < directions.size(); ++k) {
        const auto solved = [&](float x) {
            std::vector<Point> shape = mesh.vertices;
            tangential.apply(equations.wanted(gradients_of_features(
                                 plus(features, x, directions[k]), mesh.vertices.size())),
                             shape);
            return shape;
        };
        const auto a = solved(h), b = solved(-h);
        Vector3d shift = Vector3d::Zero();
        for (std::size_t i = 0; i < a.size(); ++i) {
            shift += (vec(a[i]) - vec(b[i])) / (2 * double{h} * static_cast<double>(a.size()));
        }
        double size = 0, error = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Vector3d slope = (vec(a[i]) - vec(b[i])) / (2 * double{h}) - shift;
            size = std::max(size, largest(slope));
            error = std::max(error, largest(entry(found, k, i, a.size()) - slope));
        }
        EXPECT_TRUE(error <= 1e-2 * size) << k << ": " << error << " of " << size;
    }
}

TEST(PositionDerivatives, AreTheSameForAnyNumberOfThreads) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
    const std::vector<float> features = some_features(mesh, 2);
    const std::vector<Direction> directions = some_directions(mesh, 19);
    const int before = thread_count();
    set_thread_count(1);
    const std::vector<double> one = derivatives_of(poisson, features, directions);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(derivatives_of(poisson, features, directions), one) << threads;
    }
    set_thread_count(before);
}

TEST(PositionDerivatives, RefuseWhatIsNotAFeature) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
    std::vector<float> features = some_features(mesh, 3);
    features[20] = std::numeric_limits<float>::infinity();
    std::vector<double> none;
    EXPECT_THROW(poisson.derivatives(features, {}, none), NumericalError);
    features.pop_back();
    EXPECT_THROW(poisson.derivatives(features, {}, none), MeshError);
}

}  // namespace
}  // namespace mscomp
