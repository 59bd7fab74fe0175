// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_layer.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "acap_cases.h"
#include "derivative_cases.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

constexpr LayerEquations kBoth[] = {LayerEquations::poisson, LayerEquations::tangential};

using Numbers = std::vector<double>;
using Map = Eigen::Map<const Eigen::VectorXd>;

Map vector_of(const Numbers& x) { return {x.data(), static_cast<Eigen::Index>(x.size())}; }

Numbers random_numbers(std::size_t count, std::uint64_t stream) {
    Draws draws(stream);
    Numbers result(count);
    for (double& x : result) x = draws.next();
    return result;
}

/// some_features, with turns of nearly π and of nearly 0 among them. Exact in float.
Numbers layer_features(const TriangleMesh& mesh, std::uint64_t stream) {
    Numbers result;
    for (const float x : some_features(mesh, stream)) result.push_back(x);
    Draws draws(stream + 100);
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        if (i % 4 > 1) continue;
        const double angle = i % 4 == 1 ? kPi + 1e-4 * draws.next() : 1e-9;
        const Vector3d r = angle * draws.vector().normalized();
        for (int c = 0; c < 3; ++c) {
            result[at(i * kFeatureDim + c)] = static_cast<double>(static_cast<float>(r[c]));
        }
    }
    return result;
}

std::vector<float> as_float(const Numbers& x) { return {x.begin(), x.end()}; }

Numbers positions_of(const FeatureLayer& layer, const Numbers& features) {
    Numbers result(features.size() / 3, 1e300);
    layer.positions(features, result);
    return result;
}

Numbers adjoint_of(const FeatureLayer& layer, const Numbers& features, const Numbers& by_position) {
    Numbers result(features.size(), 1e300);
    layer.adjoint(features, by_position, result);
    return result;
}

Numbers centered_numbers(const std::vector<Point>& points) {
    Vector3d mean = Vector3d::Zero();
    for (const Point& p : points) mean += vec(p) / static_cast<double>(points.size());
    Numbers result;
    for (const Point& p : points) {
        const Point entry = point(vec(p) - mean);
        result.insert(result.end(), entry.begin(), entry.end());
    }
    return result;
}

double relative_distance(const Numbers& a, const Numbers& b) {
    return largest(vector_of(a) - vector_of(b)) / largest(vector_of(b));
}

/// dp along a direction by the solvers' own derivatives().
Numbers derivative_by_solver(const TriangleMesh& mesh, LayerEquations equations,
                             const Numbers& features, const Numbers& direction) {
    std::vector<int> vertices;
    for (int i = 0; i < mesh.vertex_count(); ++i) vertices.push_back(i);
    const std::vector<float> values = as_float(direction);
    const FeatureDirection directions[] = {{vertices, values}};
    Numbers result(features.size() / 3);
    if (equations == LayerEquations::poisson) {
        PoissonReconstruction(mesh, EdgeWeights::cotangent)
            .derivatives(as_float(features), directions, result);
    } else {
        LosslessReconstruction(mesh, EdgeWeights::cotangent)
            .derivatives(as_float(features), directions, result);
    }
    return result;
}

Numbers float_direction(std::size_t count, std::uint64_t stream) {
    Numbers direction = random_numbers(count, stream);
    for (double& x : direction) x = dyadic(x);
    return direction;
}

Numbers moved(Numbers x, double step, const Numbers& direction) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += step * direction[i];
    return x;
}

TEST(FeatureLayer, OfPoissonIsItsSolve) {
    for (const TriangleMesh& mesh : small_meshes()) {
        const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
        const FeatureLayer layer(mesh, EdgeWeights::cotangent, LayerEquations::poisson);
        const Numbers features = layer_features(mesh, 1);
        const Numbers wanted = centered_numbers(poisson.solve(as_float(features)));
        EXPECT_LT(relative_distance(positions_of(layer, features), wanted), 1e-12);
    }
}

TEST(FeatureLayer, OfTangentialEquationsGivesAMeshOfItsFeatures) {
    const TriangleMesh mesh = bumpy_sphere(2), shape = mapped(mesh, wobble);
    const FeatureSet set = extract_one(mesh, shape);
    const Numbers features(set.shape(0).begin(), set.shape(0).end());
    const FeatureLayer layer(mesh, EdgeWeights::cotangent, LayerEquations::tangential);
    const Numbers found = positions_of(layer, features);
    EXPECT_LT(relative_distance(found, centered_numbers(shape.vertices)), 1e-5);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const ReconstructedShape start = lossless.solve(set.shape(0));
    ASSERT_EQ(start.steps, 0);
    EXPECT_LT(relative_distance(found, centered_numbers(start.vertices)), 1e-5);
}

TEST(FeatureLayer, GivesTheReferenceOfItsFeatures) {
    for (const LayerEquations equations : kBoth) {
        for (const TriangleMesh& mesh : small_meshes()) {
            Numbers features(mesh.vertices.size() * kFeatureDim, 0);
            for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
                for (const std::size_t c : {3, 6, 8}) features[i * kFeatureDim + c] = 1;
            }
            const FeatureLayer layer(mesh, EdgeWeights::cotangent, equations);
            EXPECT_LT(
                relative_distance(positions_of(layer, features), centered_numbers(mesh.vertices)),
                1e-12);
        }
    }
}

// Rounding counts 1 / h times, and on the spheres of few vertices the tangential equations hardly
// see a pattern that alternates.
TEST(FeatureLayer, MovesAlongTheDerivativesOfTheSolvers) {
    constexpr double h = 2e-3;
    for (const LayerEquations equations : kBoth) {
        for (const TriangleMesh& mesh : small_meshes()) {
            const FeatureLayer layer(mesh, EdgeWeights::cotangent, equations);
            const Numbers x = layer_features(mesh, 2), d = float_direction(x.size(), 3);
            const auto p = [&](double step) { return positions_of(layer, moved(x, step, d)); };
            const Numbers a = p(h), b = p(-h), c = p(2 * h), e = p(-2 * h);
            Numbers slope(a.size());
            for (std::size_t i = 0; i < a.size(); ++i) {
                slope[i] = (8 * (a[i] - b[i]) - (c[i] - e[i])) / (12 * h);
            }
            EXPECT_LT(relative_distance(derivative_by_solver(mesh, equations, x, d), slope), 1e-8);
        }
    }
}

// <g, J d> = <Jᵀ g, d>.
TEST(FeatureLayer, AdjointIsTheTransposeOfTheDerivatives) {
    for (const LayerEquations equations : kBoth) {
        for (const TriangleMesh& mesh : small_meshes()) {
            const FeatureLayer layer(mesh, EdgeWeights::cotangent, equations);
            for (std::uint64_t trial = 0; trial < 3; ++trial) {
                const Numbers x = layer_features(mesh, 10 + trial);
                const Numbers d = float_direction(x.size(), 20 + trial);
                const Numbers g = random_numbers(x.size() / 3, 30 + trial);
                const Numbers moves = derivative_by_solver(mesh, equations, x, d);
                const double wanted = vector_of(g).dot(vector_of(moves));
                const double found = vector_of(adjoint_of(layer, x, g)).dot(vector_of(d));
                EXPECT_LT(std::abs(found - wanted), 1e-10 * std::abs(wanted))
                    << mesh.vertex_count();
            }
        }
    }
}

/// Four-point differences of E = ½ Σ |p - target|² by every feature against the adjoint.
double worst_gradient_error(const FeatureLayer& layer, const Numbers& features) {
    constexpr double h = 1e-3;
    const Numbers target = random_numbers(features.size() / 3, 40);
    const auto energy = [&](const Numbers& x) {
        return 0.5 * (vector_of(positions_of(layer, x)) - vector_of(target)).squaredNorm();
    };
    const Numbers backward =
        adjoint_of(layer, features, moved(positions_of(layer, features), -1, target));
    const double floor = 1e-2 * largest(vector_of(backward));
    double worst = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
        const auto at_step = [&](double step) {
            Numbers x = features;
            x[i] += step;
            return energy(x);
        };
        const double slope =
            (8 * (at_step(h) - at_step(-h)) - (at_step(2 * h) - at_step(-2 * h))) / (12 * h);
        const double size = std::max({std::abs(slope), std::abs(backward[i]), floor});
        worst = std::max(worst, std::abs(slope - backward[i]) / size);
    }
    return worst;
}

TEST(FeatureLayer, AdjointIsTheGradientOfAnError) {
    for (const LayerEquations equations : kBoth) {
        for (const TriangleMesh& mesh : {bumpy_sphere(1), shapes::grid(6, 5), several_parts()}) {
            const FeatureLayer layer(mesh, EdgeWeights::cotangent, equations);
            EXPECT_LT(worst_gradient_error(layer, layer_features(mesh, 4)), 1e-6)
                << mesh.vertex_count();
        }
    }
}

Numbers several_shapes(const TriangleMesh& mesh, std::size_t count) {
    Numbers result;
    for (std::size_t n = 0; n < count; ++n) {
        const Numbers shape = layer_features(mesh, 50 + n);
        result.insert(result.end(), shape.begin(), shape.end());
    }
    return result;
}

Numbers part(const Numbers& x, std::size_t index, std::size_t size) {
    const auto begin = x.begin() + static_cast<std::ptrdiff_t>(index * size);
    return {begin, begin + static_cast<std::ptrdiff_t>(size)};
}

TEST(FeatureLayer, IsTheSameForAnyNumberOfThreadsAloneAndInAGroup) {
    constexpr std::size_t kShapes = 11;
    const TriangleMesh mesh = several_parts();
    const Numbers features = several_shapes(mesh, kShapes);
    const Numbers g = random_numbers(features.size() / 3, 60);
    const std::size_t size = features.size() / kShapes;
    const int before = thread_count();
    for (const LayerEquations equations : kBoth) {
        const FeatureLayer layer(mesh, EdgeWeights::cotangent, equations);
        set_thread_count(1);
        const Numbers positions = positions_of(layer, features);
        const Numbers by_feature = adjoint_of(layer, features, g);
        for (const int threads : {2, 7}) {
            set_thread_count(threads);
            EXPECT_EQ(positions_of(layer, features), positions) << threads;
            EXPECT_EQ(adjoint_of(layer, features, g), by_feature) << threads;
        }
        for (std::size_t n = 0; n < kShapes; ++n) {
            const Numbers alone = part(features, n, size);
            EXPECT_EQ(positions_of(layer, alone), part(positions, n, size / 3)) << n;
            EXPECT_EQ(adjoint_of(layer, alone, part(g, n, size / 3)), part(by_feature, n, size))
                << n;
        }
    }
    set_thread_count(before);
}

TEST(FeatureLayer, RefusesWhatDoesNotFit) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const FeatureLayer layer(mesh, EdgeWeights::cotangent, LayerEquations::poisson);
    EXPECT_EQ(layer.vertex_count(), mesh.vertex_count());
    Numbers x = several_shapes(mesh, 2), p(x.size() / 3), by_x(x.size());
    Numbers none;
    layer.positions(none, none);
    layer.adjoint(none, none, none);
    EXPECT_THROW(layer.positions(x, none), MeshError);
    EXPECT_THROW(layer.adjoint(x, none, by_x), MeshError);
    EXPECT_THROW(layer.adjoint(x, p, p), MeshError);
    x[x.size() - 2] = std::numeric_limits<double>::quiet_NaN();
    const std::string wanted = "feature of shape 1, vertex 41 is not finite";
    const auto expect_refused = [&](const auto& call) {
        try {
            call();
            FAIL();
        } catch (const NumericalError& error) {
            EXPECT_EQ(error.what(), wanted);
        }
    };
    expect_refused([&] { layer.positions(x, p); });
    expect_refused([&] { layer.adjoint(x, p, by_x); });
    x.pop_back();
    EXPECT_THROW(layer.positions(x, p), MeshError);
}

}  // namespace
}  // namespace mscomp
