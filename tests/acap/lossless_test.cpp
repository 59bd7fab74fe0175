// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "acap_cases.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

// Features are stored in float32.
constexpr double kPrecision = 1e-5;

double largest_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
    double result = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double distance = (vec(a[i]) - vec(b[i])).norm();
        if (!(distance <= result)) result = distance;
    }
    return result;
}

/// Smooth, but with a fold and a mirrored dent: rings whose faces look in opposite directions.
Vector3d folded(const Vector3d& p) {
    Vector3d q = wobble(p);
    if (p.x() > 0.6) q.x() = 1.2 - q.x();
    return q;
}

struct Case {
    const char* name;
    TriangleMesh reference, shape;
};

std::vector<Case> cases_with_exact_features() {
    const TriangleMesh ball = bumpy_sphere(3);
    const TriangleMesh sheet = shapes::grid(12, 9);
    const TriangleMesh bar = shapes::cylinder(10, 20, 0.5, 6, true);
    return {{"bent ball", ball, mapped(ball, wobble)},
            {"folded ball", ball, mapped(ball, folded)},
            {"sheet out of its plane", sheet,
             mapped(sheet,
                    [](const Vector3d& p) -> Vector3d {
                        return {p.x(), p.y(), 0.3 * std::sin(p.x()) * std::cos(p.y())};
                    })},
            {"bar twisted by three turns", bar, twisted(bar, 3, 6)}};
}

// A mesh fulfils the equations of its own features: reconstruct(extract(m)) = m.
TEST(Lossless, GivesTheMeshOfItsFeaturesBack) {
    for (const EdgeWeights weights :
         {EdgeWeights::cotangent, EdgeWeights::authors, EdgeWeights::uniform}) {
        for (const Case& c : cases_with_exact_features()) {
            const FeatureSet set = extract_one(c.reference, c.shape, false, weights);
            const LosslessReconstruction lossless(c.reference, weights);
            const ReconstructedShape result = lossless.solve(set.shape(0), c.shape.vertices);
            EXPECT_LE(largest_distance(result.vertices, c.shape.vertices), kPrecision)
                << c.name << ", " << to_string(weights);
            EXPECT_LE(result.residual, 1e-6) << c.name;
            EXPECT_TRUE(result.converged) << c.name;
            if (result.residual <= 2e-7) {
                EXPECT_EQ(result.steps, 0) << c.name;
            }
        }
    }
}

// ... which Poisson does not: the test above would notice.
TEST(Lossless, IsNotPoisson) {
    for (const Case& c : cases_with_exact_features()) {
        const FeatureSet set = extract_one(c.reference, c.shape);
        const auto poisson = PoissonReconstruction(c.reference, EdgeWeights::cotangent)
                                 .solve(set.shape(0), c.shape.vertices);
        EXPECT_GT(largest_distance(poisson, c.shape.vertices), 100 * kPrecision) << c.name;
    }
}

TEST(Lossless, CeresGivesTheMeshOfItsFeaturesBack) {
    for (const Case& c : cases_with_exact_features()) {
        const FeatureSet set = extract_one(c.reference, c.shape);
        const LosslessReconstruction lossless(c.reference, EdgeWeights::cotangent);
        const auto result = lossless.solve_by_ceres(set.shape(0), {}, c.shape.vertices);
        EXPECT_LE(largest_distance(result.vertices, c.shape.vertices), kPrecision) << c.name;
    }
}

std::vector<float> average(std::span<const float> a, std::span<const float> b) {
    std::vector<float> result;
    for (std::size_t i = 0; i < a.size(); ++i) result.push_back(0.5F * (a[i] + b[i]));
    return result;
}

Vector3d other_wobble(const Vector3d& p) {
    return rotation_about({-0.3, 1, 0.4}, 1.1 * p.x()) * p + 0.15 * p.cwiseProduct(p);
}

// Averages of features belong to no mesh. E is smooth here, and both solvers stop where its
// derivative vanishes.
TEST(Lossless, BothSolversReachTheSameMinimumWhereNoMeshHasTheFeatures) {
    const TriangleMesh mesh = bumpy_sphere(3);
    const FeatureSet a = extract_one(mesh, mapped(mesh, wobble));
    const FeatureSet b = extract_one(mesh, mapped(mesh, other_wobble));
    const std::vector<float> features = average(a.shape(0), b.shape(0));
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const ReconstructedShape fast = lossless.solve(features);
    const ReconstructedShape ceres = lossless.solve_by_ceres(features);
    EXPECT_GT(fast.residual, 1e-4);  // visible as such
    EXPECT_GT(fast.steps, 0);
    EXPECT_TRUE(fast.converged);
    EXPECT_NEAR(fast.energy, ceres.energy, 1e-5 * ceres.energy);
    EXPECT_LE(largest_distance(fast.vertices, ceres.vertices), 1e-4);
}

// The features of the result belong to a mesh, whatever it was asked for.
TEST(Lossless, FeaturesOfAResultGiveTheResultBack) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const FeatureSet a = extract_one(mesh, mapped(mesh, wobble));
    const FeatureSet b = extract_one(mesh, mapped(mesh, other_wobble));
    const LosslessReconstruction lossless(mesh, EdgeWeights::uniform);
    const ReconstructedShape found = lossless.solve(average(a.shape(0), b.shape(0)));
    const FeatureSet own =
        extract_one(mesh, {found.vertices, mesh.faces}, false, EdgeWeights::uniform);
    const ReconstructedShape again = lossless.solve(own.shape(0), found.vertices);
    EXPECT_GT(found.residual, 1e-4);
    EXPECT_LE(again.residual, 1e-6);
    EXPECT_LE(largest_distance(again.vertices, found.vertices), kPrecision);
}

// Folded sharply: faces without area have normals of chance, and still the mesh comes back.
TEST(Lossless, FacesWithoutAreaDoNoHarm) {
    const TriangleMesh sheet = shapes::grid(9, 7);
    const TriangleMesh folded_sheet = mapped(sheet, [](const Vector3d& p) -> Vector3d {
        return {std::abs(p.x() - 3.5), p.y(), 0};
    });
    const FeatureSet set = extract_one(sheet, folded_sheet);
    const LosslessReconstruction lossless(sheet, EdgeWeights::cotangent);
    const ReconstructedShape result = lossless.solve(set.shape(0), folded_sheet.vertices);
    EXPECT_LE(largest_distance(result.vertices, folded_sheet.vertices), kPrecision);
    EXPECT_LE(result.residual, 1e-6);
    EXPECT_TRUE(result.converged);
}

TEST(Lossless, AShapeCollapsedToAPointComesBack) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const TriangleMesh dot = mapped(mesh, [](const Vector3d&) -> Vector3d { return {1, 2, 3}; });
    const FeatureSet set = extract_one(mesh, dot);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    for (const ReconstructedShape& result :
         {lossless.solve(set.shape(0), dot.vertices),
          lossless.solve_by_ceres(set.shape(0), {}, dot.vertices)}) {
        EXPECT_LE(largest_distance(result.vertices, dot.vertices), kPrecision);
        EXPECT_EQ(result.residual, 0);
        EXPECT_LE(result.energy, 1e-9);
    }
}

// T = exp(r) S everywhere is fulfilled by p' = T p.
TEST(Lossless, IsLinearlyPrecise) {
    const TriangleMesh mesh = bumpy_sphere(2);
    Matrix3d s;
    s << 1.5, 0.25, -0.125, 0.25, 0.75, 0.5, -0.125, 0.5, 1.25;
    const Matrix3d turn = rotation_about({1, 2, 3}, 1);
    const TriangleMesh shape =
        mapped(mesh, [&](const Vector3d& p) -> Vector3d { return turn * s * p; });
    const FeatureSet set = extract_one(mesh, shape);
    const auto result =
        LosslessReconstruction(mesh, EdgeWeights::cotangent).solve(set.shape(0), shape.vertices);
    EXPECT_LE(largest_distance(result.vertices, shape.vertices), kPrecision);
}

TEST(Lossless, DoesNotDependOnTheUnit) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const FeatureSet set = extract_one(mesh, mapped(mesh, wobble));
    const auto one = LosslessReconstruction(mesh, EdgeWeights::cotangent).solve(set.shape(0));
    for (const double unit : {1e-6, 1e6}) {
        const TriangleMesh scaled =
            mapped(mesh, [=](const Vector3d& p) -> Vector3d { return unit * p; });
        auto other = LosslessReconstruction(scaled, EdgeWeights::cotangent).solve(set.shape(0));
        for (Point& p : other.vertices) p = point(vec(p) / unit);
        EXPECT_LE(largest_distance(other.vertices, one.vertices), 1e-6);
    }
}

TriangleMesh two_balls() {
    TriangleMesh mesh = bumpy_sphere(2);
    const int half = mesh.vertex_count();
    for (const Face& f : bumpy_sphere(2).faces) {
        mesh.faces.push_back({f[0] + half, f[1] + half, f[2] + half});
    }
    for (const Point& p : bumpy_sphere(2).vertices) {
        mesh.vertices.push_back({p[0] + 5, p[1], p[2]});
    }
    mesh.vertices.push_back({1, 2, 3});
    return mesh;
}

// Features do not say where a component lies; the shape they were taken from does.
TEST(Lossless, EveryComponentLiesWhereItLayInTheShapeOfTheFeatures) {
    const TriangleMesh mesh = two_balls();
    TriangleMesh shape = mapped(mesh, wobble);
    for (std::size_t i = 0; i < 162; ++i) shape.vertices[i][1] += 4;
    const FeatureSet set = extract_one(mesh, shape);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    EXPECT_LE(
        largest_distance(lossless.solve(set.shape(0), shape.vertices).vertices, shape.vertices),
        kPrecision);
    EXPECT_GT(largest_distance(lossless.solve(set.shape(0)).vertices, shape.vertices), 1);
    EXPECT_THROW((void)lossless.solve(set.shape(0), std::span(shape.vertices).first(3)), MeshError);
}

TEST(Lossless, IsTheSameForAnyNumberOfThreads) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const FeatureSet set = extract_one(mesh, mapped(mesh, folded));
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const auto one = lossless.solve(set.shape(0)).vertices;
    std::vector<std::vector<Point>> many(8);
    set_thread_count(4);
    parallel_for(8, [&](std::int64_t i) {
        many[static_cast<std::size_t>(i)] = lossless.solve(set.shape(0)).vertices;
    });
    set_thread_count(0);
    for (const auto& other : many) EXPECT_EQ(other, one);
}

// With the targets of the mesh itself nothing changes; elsewhere a hard handle is met exactly.
TEST(Handles, HardOnesAreMetExactly) {
    const TriangleMesh mesh = bumpy_sphere(2), shape = mapped(mesh, wobble);
    const FeatureSet set = extract_one(mesh, shape);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const std::vector<Handle> own{{3, shape.vertices[3]}, {77, shape.vertices[77]}};
    EXPECT_LE(largest_distance(lossless.solve_by_ceres(set.shape(0), own).vertices, shape.vertices),
              kPrecision);
    const std::vector<Handle> pulled{{3, shape.vertices[3]}, {77, {2, 2, 2}}};
    const ReconstructedShape result = lossless.solve_by_ceres(set.shape(0), pulled);
    EXPECT_EQ(result.vertices[3], shape.vertices[3]);
    EXPECT_EQ(result.vertices[77], (Point{2, 2, 2}));
    EXPECT_GT(result.residual, 1e-3);
}

// One handle has nothing to pull against: the shape follows it, hard or soft.
TEST(Handles, OneHandleCarriesTheShapeAlong) {
    const TriangleMesh mesh = bumpy_sphere(2), shape = mapped(mesh, wobble);
    const FeatureSet set = extract_one(mesh, shape);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const Point target = point(vec(shape.vertices[5]) + Vector3d(1, -2, 3));
    for (const double weight : {0.5, std::numeric_limits<double>::infinity()}) {
        const std::vector<Handle> handle{{5, target, weight}};
        auto result = lossless.solve_by_ceres(set.shape(0), handle).vertices;
        for (Point& p : result) p = point(vec(p) - Vector3d(1, -2, 3));
        EXPECT_LE(largest_distance(result, shape.vertices), kPrecision);
    }
}

// The heavier a soft handle, the nearer; in the limit as a hard one.
TEST(Handles, SoftOnesTendToHardOnes) {
    const TriangleMesh mesh = bumpy_sphere(2), shape = mapped(mesh, wobble);
    const FeatureSet set = extract_one(mesh, shape);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const Point target{1.5, 1, 1};
    const auto distance = [&](double weight) {
        const std::vector<Handle> handles{{3, shape.vertices[3]}, {77, target, weight}};
        const auto result = lossless.solve_by_ceres(set.shape(0), handles).vertices;
        return (vec(result[77]) - vec(target)).norm();
    };
    const double light = distance(0.1), middle = distance(1), heavy = distance(1e4);
    EXPECT_LT(middle, light);
    EXPECT_LT(heavy, 1e-2 * middle);
}

TEST(Handles, SenselessOnesAreRefused) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const FeatureSet set = extract_one(mesh, mesh);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const Handle& handle : {Handle{-1, {}}, Handle{mesh.vertex_count(), {}}, Handle{0, {}, 0},
                                 Handle{0, {}, nan}, Handle{0, {nan, 0, 0}}}) {
        EXPECT_THROW((void)lossless.solve_by_ceres(set.shape(0), std::span(&handle, 1)),
                     UsageError);
    }
}

TEST(Lossless, RefusesWhatIsNotAFeature) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const LosslessReconstruction lossless(mesh, EdgeWeights::cotangent);
    std::vector<float> features(static_cast<std::size_t>(mesh.vertex_count()) * kFeatureDim, 0);
    features[20] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW((void)lossless.solve(features), NumericalError);
    features.pop_back();
    EXPECT_THROW((void)lossless.solve(features), MeshError);
}

}  // namespace
}  // namespace mscomp
