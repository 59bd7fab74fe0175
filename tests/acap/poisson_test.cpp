// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "acap_cases.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace cases;

std::vector<float> same_feature(const TriangleMesh& mesh, const Vector3d& r, const Matrix3d& s) {
    std::vector<float> features;
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        for (const double value :
             {r.x(), r.y(), r.z(), s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2)}) {
            features.push_back(static_cast<float>(value));
        }
    }
    return features;
}

Vector3d centroid(const std::vector<Point>& points) {
    Vector3d sum = Vector3d::Zero();
    for (const Point& p : points) sum += vec(p);
    return sum / static_cast<double>(points.size());
}

std::vector<TriangleMesh> meshes() {
    return {bumpy_sphere(2), shapes::grid(6, 5), shapes::cylinder(8, 5, 1, 3, false)};
}

TEST(Poisson, FeaturesOfTheReferenceGiveTheReference) {
    for (const TriangleMesh& mesh : meshes()) {
        const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
        const auto result = poisson.solve(same_feature(mesh, {0, 0, 0}, Matrix3d::Identity()));
        for (std::size_t i = 0; i < result.size(); ++i) {
            EXPECT_LT(largest(vec(result[i]) - vec(mesh.vertices[i])), 1e-12);
        }
    }
}

// T_i = T for all i: then p' = T p solves the equation, up to the translation that keeps the
// centroid. Entries of r and S are chosen to be exact in float.
TEST(Poisson, IsLinearlyPrecise) {
    const Vector3d r(0.5, -1.25, 2);
    Matrix3d s;
    s << 1.5, 0.25, -0.125, 0.25, 0.75, 0.5, -0.125, 0.5, 1.25;
    for (const TriangleMesh& mesh : meshes()) {
        for (const EdgeWeights kind :
             {EdgeWeights::cotangent, EdgeWeights::authors, EdgeWeights::uniform}) {
            const PoissonReconstruction poisson(mesh, kind);
            const auto result = poisson.solve(same_feature(mesh, r, s));
            const Vector3d center = centroid(mesh.vertices);
            for (std::size_t i = 0; i < result.size(); ++i) {
                const Vector3d wanted = exp_of(r) * s * (vec(mesh.vertices[i]) - center) + center;
                EXPECT_LT(largest(vec(result[i]) - wanted), 1e-10);
            }
        }
    }
}

TEST(Poisson, FeaturesOfARigidMotionGiveTheTurnedReference) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const Matrix3d turn = rotation_about({1, 2, 3}, 3.0);
    const TriangleMesh shape =
        mapped(mesh, [&](const Vector3d& p) -> Vector3d { return turn * p; });
    const auto result = PoissonReconstruction(mesh, EdgeWeights::cotangent)
                            .solve(extract_one(mesh, shape).shape(0));
    const Vector3d center = centroid(mesh.vertices);
    for (std::size_t i = 0; i < result.size(); ++i) {
        EXPECT_LT(largest(vec(result[i]) - (turn * (vec(mesh.vertices[i]) - center) + center)),
                  1e-5);
    }
}

// Where shape and features vary slowly the round trip is nearly exact, and better on a finer mesh.
TEST(Poisson, RoundTripOfASmoothDeformationConverges) {
    std::vector<double> errors;
    for (const int levels : {2, 3, 4}) {
        const TriangleMesh mesh = bumpy_sphere(levels), shape = mapped(mesh, wobble);
        const auto result = PoissonReconstruction(mesh, EdgeWeights::cotangent)
                                .solve(extract_one(mesh, shape).shape(0));
        const Vector3d shift = centroid(shape.vertices) - centroid(result);
        double sum = 0;
        for (std::size_t i = 0; i < result.size(); ++i) {
            sum += (vec(result[i]) + shift - vec(shape.vertices[i])).squaredNorm();
        }
        errors.push_back(std::sqrt(sum / static_cast<double>(result.size())));
    }
    EXPECT_LT(errors[1], 0.5 * errors[0]);
    EXPECT_LT(errors[2], 0.5 * errors[1]);
    EXPECT_LT(errors[2], 5e-3);
}

// Each connected component has the centroid that it has in the shape given; a vertex without faces
// lies where it does there.
TEST(Poisson, EveryComponentHasTheCentroidOfTheShapeGiven) {
    const TriangleMesh sphere = shapes::icosphere(1);
    const int half = sphere.vertex_count();
    TriangleMesh mesh = shapes::beside(sphere, sphere, 7);
    mesh.vertices.push_back({1, 2, 3});
    const Vector3d r(0, 0, 1);
    const auto result = PoissonReconstruction(mesh, EdgeWeights::cotangent)
                            .solve(same_feature(mesh, r, Matrix3d::Identity()), mesh.vertices);
    for (int i = 0; i < half; ++i) {
        const Vector3d ball = vec(sphere.vertices[at(i)]);
        EXPECT_LT(largest(vec(result[at(i)]) - exp_of(r) * ball), 1e-12);
        EXPECT_LT(largest(vec(result[at(half + i)]) - exp_of(r) * ball - Vector3d(7, 0, 0)), 1e-12);
    }
    EXPECT_EQ(result.back(), (Point{1, 2, 3}));
}

TEST(Poisson, DoesNotDependOnTheUnit) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const FeatureSet set = extract_one(mesh, mapped(mesh, wobble));
    const auto one = PoissonReconstruction(mesh, EdgeWeights::cotangent).solve(set.shape(0));
    for (const double unit : {1e-8, 1e8}) {
        const TriangleMesh scaled =
            mapped(mesh, [=](const Vector3d& p) -> Vector3d { return unit * p; });
        const auto other =
            PoissonReconstruction(scaled, EdgeWeights::cotangent).solve(set.shape(0));
        for (std::size_t i = 0; i < one.size(); ++i) {
            EXPECT_LT(largest(vec(other[i]) / unit - vec(one[i])), 1e-11);
        }
    }
}

TEST(Poisson, RefusesWhatIsNotAFeature) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const PoissonReconstruction poisson(mesh, EdgeWeights::cotangent);
    std::vector<float> features = same_feature(mesh, {0, 0, 0}, Matrix3d::Identity());
    features[20] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(poisson.solve(features), NumericalError);
    features.pop_back();
    EXPECT_THROW(poisson.solve(features), MeshError);
}

}  // namespace
}  // namespace mscomp
