// SPDX-License-Identifier: MIT
#include "mscomp/eval/shape_measures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "moved_shapes.h"
#include "mscomp/base/error.h"
#include "shapes.h"

namespace mscomp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Two triangles: a square around the origin with corners 1 away from it.
const TriangleMesh kSquare{{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 2, 3}}};

std::vector<Point> corners(double first, double second) {
    return {{first, 0, 0}, {0, second, 0}, {-first, 0, 0}, {0, -second, 0}};
}

// Opposite corners move alike: the best rigid motion is none. Distances 0.3, 0.4, 0.3, 0.4; then 0.
TEST(ShapeMeasures, AgreeWithAnExampleByHand) {
    ShapeMeasures measures(kSquare, ShapeOrder::set);
    const ShapeErrors row = measures.add("first", kSquare.vertices, corners(1.3, 1.4), 0.25);
    EXPECT_EQ(row.name, "first");
    // 1000 sqrt( (2 * 0.09 + 2 * 0.16) / (3 * 4) ), unit ball = input here.
    EXPECT_NEAR(row.rms_error, 1000 * std::sqrt(0.5 / 12), 1e-10);
    EXPECT_NEAR(row.mean_vertex_distance, (0.3 + 0.4) / 2, 1e-14);
    EXPECT_NEAR(row.max_vertex_distance, 0.4, 1e-14);
    EXPECT_TRUE(row.worst_vertex == 1 || row.worst_vertex == 3) << row.worst_vertex;
    EXPECT_EQ(row.relative_squared_error, 0.25);

    measures.add("second", kSquare.vertices, kSquare.vertices, 0.05);
    measures.add("third", kSquare.vertices, kSquare.vertices);
    const SetErrors total = measures.total();
    EXPECT_EQ(total.shape_count, 3);
    EXPECT_NEAR(total.rms_error, 1000 * std::sqrt(0.5 / 36), 1e-10);
    EXPECT_NEAR(total.mean_vertex_distance, 0.35 / 3, 1e-14);
    EXPECT_NEAR(total.max_vertex_distance, 0.4, 1e-14);
    // Over the two that have one.
    EXPECT_NEAR(total.relative_squared_error_mean.value(), 0.15, 1e-15);
    EXPECT_EQ(total.relative_squared_error_max, 0.25);
    EXPECT_EQ(measures.shapes().size(), 3u);
    EXPECT_EQ(measures.shapes()[1].name, "second");
}

TEST(ShapeMeasures, AreThoseOfTheSingleMeasures) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const Frames truth = random_walk(mesh.vertices, 4, 0.1, 1);
    const Frames result = random_walk(mesh.vertices, 4, 0.1, 70);
    ShapeMeasures measures(mesh, ShapeOrder::sequence);
    RmsError rms_error(mesh.vertices);
    Sted sted(mesh, ShapeOrder::sequence);
    for (std::size_t f = 0; f < truth.size(); ++f) {
        const ShapeErrors& row = measures.add("", truth[f], result[f]);
        EXPECT_EQ(row.rms_error, rms_error.add(truth[f], result[f]));
        const std::vector<double> distances = vertex_distances(truth[f], result[f]);
        EXPECT_EQ(row.max_vertex_distance, *std::ranges::max_element(distances));
        EXPECT_EQ(distances[static_cast<std::size_t>(row.worst_vertex)], row.max_vertex_distance);
        sted.add(truth[f], result[f]);
    }
    EXPECT_EQ(measures.total().rms_error, rms_error.value());
    EXPECT_EQ(measures.total().sted.value, sted.value().value);
    EXPECT_TRUE(measures.total().sted.value.has_value());
    EXPECT_FALSE(measures.total().relative_squared_error_mean.has_value());
    EXPECT_FALSE(measures.total().relative_squared_error_max.has_value());
}

// Truths that were aligned one by one have lost their way through space: it is told beside them.
TEST(ShapeMeasures, TemporalPartIsOfTruthsInTheirPlaces) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const Frames in_place = random_walk(mesh.vertices, 4, 0.1, 1);
    const Frames result = random_walk(mesh.vertices, 4, 0.1, 70);
    ShapeMeasures told(mesh, ShapeOrder::sequence), lost(mesh, ShapeOrder::sequence);
    Sted sted(mesh, ShapeOrder::sequence);
    for (std::size_t f = 0; f < in_place.size(); ++f) {
        const std::vector<Point> aligned = aligned_to(mesh.vertices, in_place[f]);
        sted.add(in_place[f], result[f]);
        const ShapeErrors row = lost.add("", aligned, result[f]);
        EXPECT_EQ(told.add("", aligned, result[f], {}, in_place[f]).rms_error, row.rms_error);
    }
    EXPECT_EQ(told.total().sted.value, sted.value().value);
    EXPECT_GT(std::abs(*told.total().sted.temporal - *lost.total().sted.temporal), 1e-3);
}

TEST(ShapeMeasures, OfPerfectResultsAreZero) {
    const TriangleMesh mesh = shapes::icosphere(1);
    ShapeMeasures measures(mesh, ShapeOrder::sequence);
    for (const auto& frame : random_walk(mesh.vertices, 4, 0.1, 1))
        measures.add("", frame, frame, 0);
    const SetErrors total = measures.total();
    EXPECT_NEAR(total.rms_error, 0, 1e-10);
    EXPECT_NEAR(total.mean_vertex_distance, 0, 1e-13);
    EXPECT_NEAR(total.max_vertex_distance, 0, 1e-13);
    EXPECT_NEAR(total.sted.value.value(), 0, 1e-10);
    EXPECT_EQ(total.relative_squared_error_max, 0);
}

/// The whole of what is measured on `truth` and `result`.
struct Measured {
    SetErrors total;
    std::vector<ShapeErrors> shapes;
};

Measured measured(const TriangleMesh& reference, const Frames& truth, const Frames& result) {
    ShapeMeasures measures(reference, ShapeOrder::sequence);
    for (std::size_t f = 0; f < truth.size(); ++f) measures.add("", truth[f], result[f]);
    return {measures.total(), measures.shapes()};
}

/// Equal up to rounding, distances times `unit`.
void expect_equal(const Measured& a, const Measured& b, double unit) {
    const auto near = [](double x, double y, const char* what) {
        EXPECT_NEAR(x, y, 1e-8 * std::abs(y)) << what;
        EXPECT_GT(std::abs(y), 0) << what;
    };
    near(a.total.rms_error, b.total.rms_error, "E_rms");
    near(a.total.mean_vertex_distance, unit * b.total.mean_vertex_distance, "mean distance");
    near(a.total.max_vertex_distance, unit * b.total.max_vertex_distance, "largest distance");
    near(a.total.sted.spatial, b.total.sted.spatial, "spatial part");
    near(a.total.sted.temporal.value(), b.total.sted.temporal.value(), "temporal part");
    near(a.total.sted.value.value(), b.total.sted.value.value(), "STED");
    ASSERT_EQ(a.shapes.size(), b.shapes.size());
    for (std::size_t f = 0; f < a.shapes.size(); ++f) {
        near(a.shapes[f].rms_error, b.shapes[f].rms_error, "E_rms of a shape");
        near(a.shapes[f].mean_vertex_distance, unit * b.shapes[f].mean_vertex_distance, "mean");
        near(a.shapes[f].max_vertex_distance, unit * b.shapes[f].max_vertex_distance, "largest");
    }
}

class Invariance : public testing::Test {
  protected:
    Invariance()
        : mesh(shapes::cylinder(8, 6, 1, 3, true)), truth(random_walk(mesh.vertices, 5, 0.05, 1)) {
        for (std::size_t f = 0; f < truth.size(); ++f) {
            result.push_back(noisy(truth[f], 0.1, 200 + f));
        }
        before = measured(mesh, truth, result);
    }

    TriangleMesh mesh;
    Frames truth, result;
    Measured before;
};

// Every result may lie anywhere; all truths may be moved together (their motion is what STED sees).
TEST_F(Invariance, RigidMotionsDoNotMatter) {
    TriangleMesh moved_mesh = mesh;
    moved_mesh.vertices = placed(mesh.vertices, 2.2);
    for (std::size_t f = 0; f < truth.size(); ++f) {
        truth[f] = placed(truth[f], -0.8);
        result[f] = placed(result[f], 1.0 + static_cast<double>(f));
    }
    const Measured after = measured(moved_mesh, truth, result);
    expect_equal(after, before, 1);
    for (std::size_t f = 0; f < truth.size(); ++f) {
        EXPECT_EQ(after.shapes[f].worst_vertex, before.shapes[f].worst_vertex);
    }
}

TEST_F(Invariance, TheUnitMattersToDistancesOnly) {
    for (const double unit : {1e-3, 1e3}) {
        TriangleMesh other = mesh;
        other.vertices = placed(mesh.vertices, 0, unit);
        Frames other_truth, other_result;
        for (std::size_t f = 0; f < truth.size(); ++f) {
            other_truth.push_back(placed(truth[f], 0, unit));
            other_result.push_back(placed(result[f], 0, unit));
        }
        expect_equal(measured(other, other_truth, other_result), before, unit);
    }
}

TEST_F(Invariance, NumbersOfVerticesDoNotMatter) {
    const std::vector<int> order = CounterRandom(5, 0).permutation(mesh.vertex_count());
    Frames other_truth, other_result;
    for (std::size_t f = 0; f < truth.size(); ++f) {
        other_truth.push_back(renumbered(truth[f], order));
        other_result.push_back(renumbered(result[f], order));
    }
    const Measured after = measured(renumbered(mesh, order), other_truth, other_result);
    expect_equal(after, before, 1);
    for (std::size_t f = 0; f < truth.size(); ++f) {
        EXPECT_EQ(after.shapes[f].worst_vertex,
                  order[static_cast<std::size_t>(before.shapes[f].worst_vertex)]);
    }
}

// A result that is not finite is never a good one.
TEST_F(Invariance, NaNInOneResultShowsEverywhere) {
    for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
        Frames broken = result;
        broken[2][7][1] = bad;
        const Measured after = measured(mesh, truth, broken);
        EXPECT_TRUE(std::isnan(after.total.rms_error));
        EXPECT_TRUE(std::isnan(after.total.mean_vertex_distance));
        EXPECT_TRUE(std::isnan(after.total.max_vertex_distance));
        EXPECT_TRUE(std::isnan(after.total.sted.value.value()));
        EXPECT_EQ(worst_shapes(after.shapes, 1), std::vector<int>{2});
        EXPECT_TRUE(std::isfinite(after.shapes[1].rms_error));
    }
    ShapeMeasures measures(mesh, ShapeOrder::set);
    measures.add("", truth[0], result[0], kNaN);
    measures.add("", truth[1], result[1], 0.1);
    EXPECT_TRUE(std::isnan(measures.total().relative_squared_error_max.value()));
    EXPECT_TRUE(std::isnan(measures.total().relative_squared_error_mean.value()));
}

TEST(ShapeMeasures, OfNothingAreNaN) {
    const ShapeMeasures measures(kSquare, ShapeOrder::set);
    EXPECT_TRUE(std::isnan(measures.total().rms_error));
    EXPECT_TRUE(std::isnan(measures.total().mean_vertex_distance));
    EXPECT_TRUE(std::isnan(measures.total().max_vertex_distance));
    EXPECT_EQ(measures.total().shape_count, 0);
}

TEST(ShapeMeasures, RefuseAnotherNumberOfVertices) {
    ShapeMeasures measures(kSquare, ShapeOrder::set);
    const std::vector<Point> other = shapes::icosphere(0).vertices;
    EXPECT_THROW(measures.add("", other, other), MeshError);
    EXPECT_THROW(measures.add("", kSquare.vertices, other), MeshError);
    EXPECT_TRUE(measures.shapes().empty());
    EXPECT_TRUE(std::isnan(measures.total().rms_error));
}

TEST(WorstShapes, AreThoseWithTheLargestErrorNaNFirst) {
    std::vector<ShapeErrors> shapes(5);
    const std::vector<double> errors{2, 5, kNaN, 5, 9};
    for (std::size_t i = 0; i < shapes.size(); ++i) shapes[i].rms_error = errors[i];
    EXPECT_EQ(worst_shapes(shapes, 4), (std::vector<int>{2, 4, 1, 3}));
    EXPECT_EQ(worst_shapes(shapes, 99), (std::vector<int>{2, 4, 1, 3, 0}));
    EXPECT_TRUE(worst_shapes(shapes, 0).empty());
    EXPECT_TRUE(worst_shapes({}, 3).empty());
}

}  // namespace
}  // namespace mscomp
