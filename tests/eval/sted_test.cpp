// SPDX-License-Identifier: MIT
#include "mscomp/eval/sted.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "moved_shapes.h"
#include "mscomp/base/error.h"
#include "mscomp/eval/measures.h"
#include "shapes.h"

namespace mscomp {
namespace {

StedError sted_of(const TriangleMesh& reference, const Frames& truth, const Frames& result,
                  ShapeOrder order = ShapeOrder::sequence, const StedOptions& options = {}) {
    Sted sted(reference, order, options);
    for (std::size_t f = 0; f < truth.size(); ++f) sted.add(truth[f], result[f]);
    return sted.value();
}

/// A rectangle of two triangles; its edges are 3, 4, 3, 4 and the diagonal 5 long.
const TriangleMesh kRectangle{{{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {0, 4, 0}}, {{0, 1, 2}, {0, 2, 3}}};

/// A regular tetrahedron around the origin whose corners are `radius` away from it.
TriangleMesh tetrahedron(double radius) {
    const double r = radius / std::sqrt(3.0);
    return {{{r, r, r}, {r, -r, -r}, {-r, r, -r}, {-r, -r, r}},
            {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

Frames tetrahedra(const std::vector<double>& radii) {
    Frames frames;
    for (const double radius : radii) frames.push_back(tetrahedron(radius).vertices);
    return frames;
}

// Corner D moves by 3 along x: CD grows from 3 to 6 (u = 1), DA from 4 to 5 (u = 1/4).
TEST(Sted, SpatialPartIsTheWeightedDeviationOfRelativeLengths) {
    std::vector<Point> result = kRectangle.vertices;
    result[3] = {-3, 4, 0};
    // A: lengths 3, 5, 4 with u = 0, 0, 1/4: m = 1/12, (3 + 5) (1/12)^2 + 4 (1/6)^2 = 1/6, over 12.
    const double a = std::sqrt((8 * (1.0 / 144) + 4 * (1.0 / 36)) / 12);
    // C: lengths 4, 5, 3 with u = 0, 0, 1: m = 3/12 = 1/4.
    const double c = std::sqrt((9 * (1.0 / 16) + 3 * (9.0 / 16)) / 12);
    // D: lengths 3, 4 with u = 1, 1/4: m = (3 + 1) / 7 = 4/7, deviations 3/7 and 9/28.
    const double d = std::sqrt((3 * (9.0 / 49) + 4 * (81.0 / 784)) / 7);
    const double b = 0;
    const StedError error = sted_of(kRectangle, {kRectangle.vertices}, {result}, ShapeOrder::set);
    EXPECT_NEAR(error.spatial, (a + b + c + d) / 4, 1e-14);
}

// Two frames count alike: one without error halves the mean.
TEST(Sted, SpatialPartIsTheMeanOverFrames) {
    std::vector<Point> result = kRectangle.vertices;
    result[3] = {-3, 4, 0};
    const std::vector<Point>& truth = kRectangle.vertices;
    const StedError one = sted_of(kRectangle, {truth}, {result});
    const StedError two = sted_of(kRectangle, {truth, truth}, {result, truth});
    EXPECT_NEAR(two.spatial, one.spatial / 2, 1e-14);
}

// Reference radius 2: the scale is 1/2. With dt = 3 a step of 8 is sqrt(4^2 + 3^2) = 5 long, no
// step 3. truth   2 -> 10 -> 10 -> 18:  t  = 5, 3, 5 result  2 ->  2 -> 10 -> 10:  t' = 3, 5, 3,
// differences 2, 2, 2 M = (5 + 3) / 2, (5 + 3 + 5) / 3, (3 + 5) / 2.
TEST(Sted, TemporalPartIsTheChangeOfStepsOverTheMeanOfTheWindow) {
    const StedOptions options{.window = 1, .dt = 3, .temporal_weight = 0.5};
    const StedError error = sted_of(tetrahedron(2), tetrahedra({2, 10, 10, 18}),
                                    tetrahedra({2, 2, 10, 10}), ShapeOrder::sequence, options);
    const double temporal = (2 / 4.0 + 2 / (13 / 3.0) + 2 / 4.0) / 3;
    ASSERT_TRUE(error.temporal && error.value);
    EXPECT_NEAR(*error.temporal, temporal, 1e-14);
    // All edges change alike: the spatial part is 0.
    EXPECT_NEAR(error.spatial, 0, 1e-14);
    EXPECT_NEAR(*error.value, 0.5 * temporal, 1e-14);
}

// The same with w = 0: every step over its own length.
TEST(Sted, WindowZeroNormalisesByTheStepItself) {
    const StedOptions options{.window = 0, .dt = 3, .temporal_weight = 1};
    const StedError error = sted_of(tetrahedron(2), tetrahedra({2, 10, 10, 18}),
                                    tetrahedra({2, 2, 10, 10}), ShapeOrder::sequence, options);
    EXPECT_NEAR(error.temporal.value(), (2 / 5.0 + 2 / 3.0 + 2 / 5.0) / 3, 1e-14);
}

// sqrt(spatial^2 + c^2 temporal^2), c = 0.127.
TEST(Sted, IsTheHypotenuseOfItsParts) {
    const TriangleMesh sphere = shapes::icosphere(1);
    const Frames truth = random_walk(sphere.vertices, 3, 0.1, 1);
    const StedError error = sted_of(sphere, truth, random_walk(sphere.vertices, 3, 0.1, 8));
    ASSERT_TRUE(error.temporal && error.value);
    EXPECT_GT(*error.temporal, 0.1);
    EXPECT_GT(error.spatial, 0.01);
    EXPECT_NEAR(*error.value * *error.value,
                error.spatial * error.spatial + 0.127 * 0.127 * *error.temporal * *error.temporal,
                1e-14);
}

/// The definition, from lists of all edges and all steps at once.
struct BruteForce {
    double spatial = 0, temporal = 0;
};

BruteForce brute_force(const TriangleMesh& mesh, const Frames& truth, const Frames& result, int w,
                       double dt) {
    const auto n = static_cast<int>(mesh.vertices.size());
    const auto frames = static_cast<int>(truth.size());
    const auto at = [](const Frames& all, int f, int v) {
        return Eigen::Vector3d(
            all[static_cast<std::size_t>(f)][static_cast<std::size_t>(v)].data());
    };
    std::set<std::pair<int, int>> edges;
    for (const Face& face : mesh.faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            edges.insert(std::minmax(face[k], face[(k + 1) % 3]));
        }
    }
    Eigen::Vector3d center = Eigen::Vector3d::Zero();
    for (const Point& p : mesh.vertices) center += Eigen::Vector3d(p.data()) / n;
    double radius = 0;
    for (const Point& p : mesh.vertices) {
        radius = std::max(radius, (Eigen::Vector3d(p.data()) - center).norm());
    }
    BruteForce error;
    for (int f = 0; f < frames; ++f) {
        for (int v = 0; v < n; ++v) {
            double weight = 0, first = 0, second = 0;  // moments of the relative change
            for (const auto& [a, b] : edges) {
                if (a != v && b != v) continue;
                const double length = (at(truth, f, a) - at(truth, f, b)).norm();
                const double u =
                    std::abs((at(result, f, a) - at(result, f, b)).norm() / length - 1);
                weight += length;
                first += length * u;
                second += length * u * u;
            }
            error.spatial += std::sqrt(second / weight - first * first / (weight * weight));
        }
    }
    const auto step = [&](const Frames& all, int f, int v) {
        return std::sqrt(((at(all, f + 1, v) - at(all, f, v)) / radius).squaredNorm() + dt * dt);
    };
    for (int v = 0; v < n; ++v) {
        for (int f = 0; f + 1 < frames; ++f) {
            double mean = 0, count = 0;
            for (int g = 0; g + 1 < frames; ++g) {
                if (std::abs(g - f) > w) continue;
                mean += step(truth, g, v);
                ++count;
            }
            error.temporal += std::abs(step(result, f, v) - step(truth, f, v)) / (mean / count);
        }
    }
    return {error.spatial / (frames * n), error.temporal / ((frames - 1) * n)};
}

// Frame by frame gives what the definition gives on everything at once, for windows shorter and
// longer than the sequence.
TEST(Sted, AgreesWithTheDefinitionOnRandomFrames) {
    const TriangleMesh mesh = shapes::cylinder(7, 5, 1.3, 4, true);
    for (const int count : {2, 3, 4, 9}) {
        const Frames truth = random_walk(mesh.vertices, count, 0.02, 3);
        Frames result;
        for (std::size_t f = 0; f < truth.size(); ++f) {
            result.push_back(aligned_to(truth[f], noisy(truth[f], 0.05, 100 + f)));
        }
        for (const int w : {0, 1, 2, 20}) {
            const StedOptions options{.window = w, .dt = 0.002, .temporal_weight = 0.127};
            const StedError error = sted_of(mesh, truth, result, ShapeOrder::sequence, options);
            const BruteForce wanted = brute_force(mesh, truth, result, w, 0.002);
            EXPECT_NEAR(error.spatial, wanted.spatial, 1e-9 * wanted.spatial);
            EXPECT_NEAR(error.temporal.value(), wanted.temporal, 1e-9 * wanted.temporal)
                << count << " frames, window " << w;
        }
    }
}

// Asking in between changes nothing.
TEST(Sted, MayBeAskedAtAnyTime) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const Frames truth = random_walk(mesh.vertices, 6, 0.1, 1);
    const Frames result = random_walk(mesh.vertices, 6, 0.1, 50);
    Sted sted(mesh, ShapeOrder::sequence);
    for (std::size_t f = 0; f < truth.size(); ++f) {
        sted.add(truth[f], result[f]);
        const StedError now = sted.value();
        const StedError alone =
            sted_of(mesh, {truth.begin(), truth.begin() + static_cast<long>(f) + 1},
                    {result.begin(), result.begin() + static_cast<long>(f) + 1});
        EXPECT_EQ(now.spatial, alone.spatial);
        EXPECT_EQ(now.temporal, alone.temporal);
    }
}

TEST(Sted, OfAPerfectResultIsZero) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const Frames truth = random_walk(mesh.vertices, 5, 0.1, 1);
    const StedError error = sted_of(mesh, truth, truth);
    EXPECT_NEAR(error.spatial, 0, 1e-12);
    EXPECT_NEAR(error.temporal.value(), 0, 1e-10);
    EXPECT_NEAR(error.value.value(), 0, 1e-11);
}

TEST(Sted, HasNoTemporalPartWithoutOrderOrASecondFrame) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const Frames truth = random_walk(mesh.vertices, 3, 0.1, 1);
    const StedError of_set = sted_of(mesh, truth, truth, ShapeOrder::set);
    EXPECT_FALSE(of_set.temporal || of_set.value);
    EXPECT_TRUE(std::isfinite(of_set.spatial));
    const StedError of_one = sted_of(mesh, {truth[0]}, {truth[0]});
    EXPECT_FALSE(of_one.temporal || of_one.value);
    const StedError of_none = sted_of(mesh, {}, {});
    EXPECT_TRUE(std::isnan(of_none.spatial));
    EXPECT_FALSE(of_none.temporal || of_none.value);
}

// The order of frames matters to the temporal part only.
TEST(Sted, SeesTheOrderOfFramesInTheTemporalPartOnly) {
    const TriangleMesh mesh = shapes::icosphere(1);
    Frames truth = random_walk(mesh.vertices, 4, 0.1, 1),
           result = random_walk(mesh.vertices, 4, 0.1, 9);
    const StedError before = sted_of(mesh, truth, result);
    std::swap(truth[1], truth[3]);
    std::swap(result[1], result[3]);
    const StedError after = sted_of(mesh, truth, result);
    EXPECT_NEAR(after.spatial, before.spatial, 1e-14);
    EXPECT_GT(std::abs(*after.temporal - *before.temporal), 1e-3);
}

// A vertex without edges and an edge that has no length in the truth are no division by zero.
TEST(Sted, LeavesOutWhatHasNoLength) {
    TriangleMesh mesh = kRectangle;
    std::vector<Point> result = mesh.vertices;
    result[3] = {-3, 4, 0};
    mesh.vertices.push_back({1, 1, 0});  // no face uses it
    mesh.vertices.push_back({0, 0, 0});  // on A, joined with it
    mesh.faces.push_back({0, 5, 0});
    const std::vector<Point>& truth = mesh.vertices;
    result.push_back(truth[4]);
    result.push_back({0, 0, 9});
    const StedError error = sted_of(mesh, {truth, truth}, {result, result});
    // As in the rectangle alone.
    const double corners = std::sqrt(1.0 / 72) + std::sqrt(3.0 / 16) + std::sqrt(27.0 / 196);
    EXPECT_NEAR(error.spatial, corners / 4, 1e-13);
}

TEST(Sted, OfAResultWithNaNIsNaN) {
    const TriangleMesh mesh = shapes::icosphere(1);
    Frames truth = random_walk(mesh.vertices, 3, 0.1, 1), result = truth;
    result[1][4][2] = std::numeric_limits<double>::quiet_NaN();
    const StedError error = sted_of(mesh, truth, result);
    EXPECT_TRUE(std::isnan(error.spatial));
    EXPECT_TRUE(std::isnan(error.temporal.value()));
    EXPECT_TRUE(std::isnan(error.value.value()));
}

TEST(Sted, RefusesWhatDoesNotFit) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const std::vector<Point> other = shapes::icosphere(0).vertices;
    Sted sted(mesh, ShapeOrder::sequence);
    EXPECT_THROW(sted.add(other, other), MeshError);
    EXPECT_THROW(sted.add(mesh.vertices, other), MeshError);
    EXPECT_THROW(Sted(TriangleMesh{}, ShapeOrder::set), MeshError);
    for (const StedOptions& options :
         {StedOptions{.window = -1}, StedOptions{.dt = 0}, StedOptions{.temporal_weight = -1},
          StedOptions{.dt = std::numeric_limits<double>::quiet_NaN()}}) {
        EXPECT_THROW(Sted(mesh, ShapeOrder::sequence, options), UsageError);
    }
}

}  // namespace
}  // namespace mscomp
