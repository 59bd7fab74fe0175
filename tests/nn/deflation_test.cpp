// SPDX-License-Identifier: MIT
#include "learning/deflation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "mscomp/base/random.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

constexpr double kReach = 0.2;
constexpr int kRowShapes = 8;

/// A sphere of 162 vertices with rows (V,9,kRowShapes) to be explained, and places within kReach.
struct Ground {
    TriangleMesh mesh = shapes::icosphere(2);
    SphereDistances distances{mesh.vertices};
    std::vector<double> rows = std::vector<double>(mesh.vertices.size() * 9 * kRowShapes);

    double& at(int vertex, int channel, int shape) {
        return rows[static_cast<std::size_t>((vertex * 9 + channel) * kRowShapes + shape)];
    }
    /// The vertices in the ball move along one channel, all by the code of the shape.
    void move_ball(int center, double radius, int channel, double size, std::uint64_t stream) {
        const CounterRandom random(2, stream);
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            if (distances.row(center)[static_cast<std::size_t>(v)] > radius) continue;
            for (int m = 0; m < kRowShapes; ++m) {
                // A random sign: the energy of every vertex is kRowShapes size^2.
                const double sign = random.uniform(static_cast<std::uint64_t>(m)) < 0.5 ? -1 : 1;
                at(v, channel, m) = std::atanh(size * sign);
            }
        }
    }
    void move_at_random() {
        const CounterRandom random(3, 0);
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = 0.3 * random.normal(i);
    }
    DeflationResidual residual() const {
        DeflationResidual result(mesh.vertex_count(), kRowShapes);
        result.fill(rows.data(), kRowShapes, 0, kRowShapes, [](double x) { return std::tanh(x); });
        result.drop_silent_vertices();
        return result;
    }
    FreePlaces within_reach() {
        return [this](int center, std::span<const int> vertices) {
            std::vector<int> places;
            for (std::size_t n = 0; n < vertices.size(); ++n) {
                const auto v = static_cast<std::size_t>(vertices[n]);
                if (distances.row(center)[v] <= kReach) places.push_back(static_cast<int>(n));
            }
            return places;
        };
    }
};

// The first is 0; each of the others is as far as any vertex is from those before it.
TEST(SpreadVertices, AreEachAsFarAsPossibleFromThoseBefore) {
    SphereDistances distances(shapes::icosphere(2).vertices);
    const std::vector<int> spread = spread_vertices(distances, 64);
    ASSERT_EQ(spread.size(), 64U);
    EXPECT_EQ(spread[0], 0);
    EXPECT_EQ(std::set<int>(spread.begin(), spread.end()).size(), 64U);
    const auto nearest = [&](int vertex, std::size_t count) {
        double least = 2;
        for (std::size_t i = 0; i < count; ++i) {
            least = std::min(least, distances.row(spread[i])[static_cast<std::size_t>(vertex)]);
        }
        return least;
    };
    for (std::size_t i = 1; i < spread.size(); ++i) {
        const double got = nearest(spread[i], i);
        for (int v = 0; v < distances.vertex_count(); ++v) EXPECT_LE(nearest(v, i), got);
    }
}

TEST(SpreadVertices, OfFewVerticesAreAllOfThem) {
    SphereDistances distances(shapes::icosphere(0).vertices);
    std::vector<int> spread = spread_vertices(distances, 64);
    std::ranges::sort(spread);
    std::vector<int> all(12);
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(spread, all);
    EXPECT_EQ(spread_vertices(distances, 1), std::vector<int>{0});
    EXPECT_EQ(spread_vertices(distances, 5).size(), 5U);
}

// A ball whose vertices move by 0.3 each has more energy than one vertex that moves by 0.8: with
// candidates it comes first, without any the vertex does.
TEST(Deflation, PrefersABallToOneHotVertex) {
    for (const bool has_candidates : {true, false}) {
        Ground ground;
        constexpr int kBall = 0, kHot = 3;  // opposite vertices of the icosahedron
        ASSERT_GT(ground.distances.row(kBall)[kHot], 0.9);
        ground.move_ball(kBall, 0.15, 1, 0.3, 0);
        ground.move_ball(kHot, 0, 2, 0.8, 1);
        DeflationResidual residual = ground.residual();
        EXPECT_EQ(residual.strongest_vertex(), kHot);
        std::vector<int> candidates;
        if (has_candidates) candidates = spread_vertices(ground.distances, 16);
        const auto found =
            deflate(residual, 2, ground.distances, ground.within_reach(), candidates);
        ASSERT_EQ(found.size(), 2U);
        const FoundComponent& ball = found[has_candidates ? 0 : 1];
        const FoundComponent& hot = found[has_candidates ? 1 : 0];
        EXPECT_EQ(hot.center, kHot);
        EXPECT_LE(ground.distances.row(kBall)[static_cast<std::size_t>(ball.center)], kReach);
        EXPECT_NEAR(hot.energy, kRowShapes * 0.64, 1e-9);
        EXPECT_GT(ball.energy, hot.energy);
        EXPECT_NEAR(ball.energy,
                    static_cast<double>(ball.direction.places.size()) * kRowShapes * 0.09, 1e-9);
    }
}

// Directions have unit length, so what a component explains is what the residual loses: nothing is
// counted twice.
TEST(Deflation, TakesOutWhatItExplains) {
    for (const int most : {16, 0}) {
        Ground ground;
        ground.move_at_random();
        DeflationResidual residual = ground.residual();
        const double before = residual.energy();
        std::vector<int> candidates;
        if (most > 0) candidates = spread_vertices(ground.distances, most);
        double explained = 0;
        const auto all = deflate(residual, 12, ground.distances, ground.within_reach(), candidates);
        for (const FoundComponent& found : all) {
            EXPECT_GT(found.energy, 0);
            EXPECT_NEAR(found.direction.explained(), found.energy, 1e-12 * before);
            double length = 0;
            for (const double x : found.direction.values) length += x * x;
            EXPECT_NEAR(length, 1, 1e-12);
            explained += found.energy;
        }
        ASSERT_EQ(all.size(), 12U);
        EXPECT_GT(explained, 0.1 * before);
        EXPECT_NEAR(residual.energy(), before - explained, 1e-10 * before);
        // What is left of every vertex is what the whole is of.
        double sum = 0;
        for (const double energy : residual.energies()) {
            EXPECT_GE(energy, 0);
            sum += energy;
        }
        EXPECT_NEAR(sum, residual.energy(), 1e-12 * before);
    }
}

// A direction acts only where its centre allows it.
TEST(Deflation, StaysWithinReach) {
    Ground ground;
    ground.move_at_random();
    DeflationResidual residual = ground.residual();
    const auto all = deflate(residual, 6, ground.distances, ground.within_reach(),
                             spread_vertices(ground.distances, 16));
    for (const FoundComponent& found : all) {
        EXPECT_EQ(found.direction.places, ground.within_reach()(found.center, residual.vertices()));
    }
}

// Once everything is explained, components are all zero with a centre on the mesh.
TEST(Deflation, OfNothingLeftIsZero) {
    Ground ground;
    ground.move_ball(5, 0.1, 0, 0.5, 0);
    DeflationResidual residual = ground.residual();
    const auto all = deflate(residual, 3, ground.distances, ground.within_reach(),
                             spread_vertices(ground.distances, 16));
    ASSERT_EQ(all.size(), 3U);
    EXPECT_GT(all[0].energy, 0);
    for (std::size_t k = 1; k < 3; ++k) {
        EXPECT_TRUE(all[k].direction.places.empty());
        EXPECT_TRUE(all[k].direction.values.empty());
        EXPECT_TRUE(all[k].center >= 0 && all[k].center < ground.mesh.vertex_count());
    }
    EXPECT_NEAR(residual.energy(), 0, 1e-12);
}

// Of nine channels a narrower model takes the first ones, a wider one nine.
TEST(Deflation, WritesTheChannelsThatThereAre) {
    Ground ground;
    ground.move_at_random();
    const DeflationResidual residual = ground.residual();
    const DeflationDirection direction = residual.main_direction(4, {1, 4, 9});
    for (const int width : {5, 9, 12}) {
        std::vector<double> row(ground.mesh.vertices.size() * static_cast<std::size_t>(width), 7.0);
        write_direction(residual, direction, width, std::span<double>(row));
        for (int v = 0; v < ground.mesh.vertex_count(); ++v) {
            const auto place = std::ranges::find(direction.places, v) - direction.places.begin();
            for (int c = 0; c < width; ++c) {
                const bool is_written = place < 3 && c < 9;
                EXPECT_EQ(
                    row[static_cast<std::size_t>(v * width + c)],
                    is_written ? direction.values[static_cast<std::size_t>(place * 9 + c)] : 7.0);
            }
        }
    }
}

}  // namespace
}  // namespace mscomp::nn
