// SPDX-License-Identifier: MIT
// Features of mirror images, against those of shapes that are mirror images.
#include "mscomp/acap/mirrored_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "mirror_cases.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

TriangleMesh turned(const TriangleMesh& mesh) {
    return mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return rotation_about({1, 2, 3}, 1.1) * p + Vector3d(1, -2, 0.5);
    });
}

/// A body and shapes of it, none of them symmetric.
struct Shapes {
    TriangleMesh reference;
    std::vector<TriangleMesh> deformed{mapped(reference, wobble), twisted(reference, 0.2, 2)};
    FeatureSet set = extract_features(sequence_of(deformed), reference.vertices, {.align = false});
    MemoryFeatures features{set.features, reference.vertex_count()};
    Mirror mirror = mirror_of(reference).value();

    explicit Shapes(TriangleMesh mesh) : reference(std::move(mesh)) {}

    /// Shape n as a mirror shows it: everyone stands where its partner stood.
    TriangleMesh in_the_mirror(int n) const {
        TriangleMesh result = reference;
        for (int v = 0; v < reference.vertex_count(); ++v) {
            const int partner = main_corner(mirror.partners[at(v)]);
            result.vertices[at(v)] = mirror.reflected(deformed[at(n)].vertices[at(partner)]);
        }
        return result;
    }
};

double farthest(std::span<const float> row, std::span<const float> other) {
    double result = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        result = std::max(result, static_cast<double>(std::abs(row[i] - other[i])));
    }
    return result;
}

double mean_distance(std::span<const float> row, std::span<const float> other) {
    double sum = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        sum += static_cast<double>(std::abs(row[i] - other[i]));
    }
    return sum / static_cast<double>(row.size());
}

TEST(MirroredFeatures, AreThoseOfTheMirroredShapes) {
    const Shapes shapes(turned(two_sided_body(3)));
    const MirroredFeatures all(shapes.features, shapes.mirror);
    for (int n = 0; n < 2; ++n) {
        const FeatureSet truth = extract_one(shapes.reference, shapes.in_the_mirror(n));
        EXPECT_LT(farthest(all.shape(2 + n), truth.shape(0)), 1e-5);
        EXPECT_GT(farthest(all.shape(n), truth.shape(0)), 0.1);  // it is not its own mirror image
    }
}

// Best rigid motions of mirror images are mirror images.
TEST(MirroredFeatures, AreThoseOfTheMirroredShapesAligned) {
    const Shapes shapes(turned(two_sided_body(3)));
    const FeatureSet set = extract_one(shapes.reference, shapes.deformed[0], true);
    const MemoryFeatures features(set.features, set.vertex_count());
    const FeatureSet truth = extract_one(shapes.reference, shapes.in_the_mirror(0), true);
    EXPECT_LT(farthest(MirroredFeatures(features, shapes.mirror).shape(1), truth.shape(0)), 1e-5);
}

TEST(MirroredFeatures, BeginWithTheShapesAsTheyAre) {
    const Shapes shapes(two_sided_body(2));
    const MirroredFeatures all(shapes.features, shapes.mirror);
    EXPECT_EQ(all.shape_count(), 4);
    EXPECT_EQ(all.vertex_count(), shapes.reference.vertex_count());
    EXPECT_EQ(all.shape(1).data(), shapes.features.shape(1).data());
}

TEST(MirroredFeatures, TwiceAreTheShapes) {
    const Shapes shapes(turned(two_sided_body(3)));
    const MirroredFeatures once(shapes.features, shapes.mirror), twice(once, shapes.mirror);
    for (int n = 0; n < 2; ++n) {
        EXPECT_LT(farthest(twice.shape(4 + 2 + n), shapes.features.shape(n)), 3e-6);
    }
}

// Where no vertex has a mirror image what is lost goes with the length of the edges.
TEST(MirroredFeatures, TwiceAreTheShapesToTheErrorOfInterpolation) {
    std::vector<double> errors;
    for (const int levels : {3, 4}) {
        const Shapes shapes(two_sided_body_askew(levels));
        const MirroredFeatures once(shapes.features, shapes.mirror), twice(once, shapes.mirror);
        errors.push_back(mean_distance(twice.shape(6), shapes.features.shape(0)));
    }
    EXPECT_LT(errors[0], 0.005);
    EXPECT_LT(errors[1], 0.5 * errors[0]);
}

// A field that is linear in space is so within every face, so that it is exact but for how far
// the reflected vertices are from the surface; at vertices beside them it would be wrong by 0.1.
TEST(MirroredFeatures, LieBetweenTheVertices) {
    const TriangleMesh mesh = two_sided_body_askew(3);
    const Mirror mirror = mirror_of(mesh).value();
    const auto rotation_at = [](const Vector3d& p) -> Vector3d {
        return {0.5 * p.y() + p.x(), p.z() - 0.3 * p.x(), p.x() + p.y()};
    };
    std::vector<float> row;
    for (const Point& p : mesh.vertices) {
        for (const double x : rotation_at(vec(p))) row.push_back(static_cast<float>(x));
        row.insert(row.end(), kReferenceFeature.begin() + kRotationDim, kReferenceFeature.end());
    }
    const MemoryFeatures features(row, mesh.vertex_count());
    const MirroredFeatures all(features, mirror);
    const std::span<const float> mirrored = all.shape(1);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const Vector3d truth =
            -mirror.matrix * rotation_at(vec(mirror.reflected(mesh.vertices[at(v)])));
        const Eigen::Map<const Eigen::Vector3f> r(&mirrored[at(v) * kFeatureDim]);
        EXPECT_LT((r.cast<double>() - truth).norm(), 0.03) << "vertex " << v;
    }
}

TEST(MirroredFeatures, OfTheReferenceAreThoseOfTheReference) {
    const Shapes shapes(turned(two_sided_body_askew(2)));
    std::vector<float> rest;
    for (int v = 0; v < shapes.reference.vertex_count(); ++v) {
        rest.insert(rest.end(), kReferenceFeature.begin(), kReferenceFeature.end());
    }
    const MemoryFeatures features(rest, shapes.reference.vertex_count());
    EXPECT_LT(farthest(MirroredFeatures(features, shapes.mirror).shape(1), rest), 1e-6);
}

/// Counts what is asked of others.
class CountingFeatures final : public ShapeFeatures {
  public:
    explicit CountingFeatures(const ShapeFeatures& features) : features_(features) {}
    int shape_count() const override { return features_.shape_count(); }
    int vertex_count() const override { return features_.vertex_count(); }
    std::span<const float> shape(int index) const override {
        ++asked;
        return features_.shape(index);
    }
    void forget(int) const override { ++forgotten; }

    mutable std::atomic<int> asked = 0, forgotten = 0;

  private:
    const ShapeFeatures& features_;
};

TEST(MirroredFeatures, AreMadeWhenAskedForAndKeptUntilForgotten) {
    const Shapes shapes(two_sided_body(2));
    const CountingFeatures source(shapes.features);
    const MirroredFeatures all(source, shapes.mirror);
    EXPECT_EQ(source.asked, 0);
    const std::span<const float> row = all.shape(3);
    EXPECT_EQ(all.shape(3).data(), row.data());
    EXPECT_EQ(source.asked, 1);
    const std::vector<float> before(row.begin(), row.end());
    all.forget(3);
    EXPECT_EQ(source.forgotten, 0);
    EXPECT_TRUE(std::ranges::equal(all.shape(3), before));
    EXPECT_EQ(source.asked, 2);
    all.forget(0);
    EXPECT_EQ(source.forgotten, 1);
}

TEST(MirroredFeatures, MayBeAskedForFromSeveralThreads) {
    const Shapes shapes(two_sided_body_askew(3));
    const MirroredFeatures one(shapes.features, shapes.mirror),
        many(shapes.features, shapes.mirror);
    set_thread_count(7);
    std::vector<const float*> seen(64);
    parallel_for(64,
                 [&](std::int64_t i) { seen[at(i)] = many.shape(static_cast<int>(i % 4)).data(); });
    set_thread_count(0);
    for (int i = 0; i < 64; ++i) EXPECT_EQ(seen[at(i)], many.shape(i % 4).data());
    for (int n = 0; n < 4; ++n) EXPECT_TRUE(std::ranges::equal(one.shape(n), many.shape(n)));
}

}  // namespace
}  // namespace mscomp
