// SPDX-License-Identifier: MIT
#include "neighbor_starts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "acap_cases.h"
#include "mscomp/base/parallel.h"
#include "shape_extraction.h"

namespace mscomp {
namespace {

using namespace cases;

constexpr int kShapes = 7;
using Vectors = std::vector<Vector3d>;

double energy_of(const ConsistencyGraph& graph, const Vectors& r) {
    double energy = 0;
    for (const auto& [i, j] : graph.edges) energy += (r[at(i)] - r[at(j)]).squaredNorm();
    return energy;
}

/// Copies of one shape, a strip that twists by several turns; `good` of them have the right turns,
/// the others stay where the first vertex moved would lead them.
struct Copies {
    explicit Copies(const std::vector<int>& good)
        : mesh(shapes::cylinder(8, 40, 1, 30, false)),
          graph(consistency_graph(one_rings_of_faces(mesh.vertex_count(), mesh.faces),
                                  std::vector<double>(at(mesh.vertex_count()), 0.0))) {
        right.reserve(mesh.vertices.size());
        for (const Point& p : mesh.vertices) right.emplace_back(0, 0, 0.6 * p[2] + 0.1);
        wrong = right;
        // A band of rings a turn too far: no single vertex that moves alone helps.
        for (Vector3d& r : wrong) {
            if (r.z() > 5 && r.z() < 12) r.z() += 2 * std::numbers::pi;
        }
        set.names.resize(kShapes);
        set.reference = mesh;
        set.features.resize(kShapes * mesh.vertices.size() * kFeatureDim);
        summaries.resize(kShapes);
        for (int n = 0; n < kShapes; ++n) {
            const bool is_good = std::find(good.begin(), good.end(), n) != good.end();
            store_rotation_vectors(is_good ? right : wrong, row(n));
            summaries[at(n)].energy = energy_of(graph, is_good ? right : wrong);
        }
    }
    std::span<float> row(int shape) {
        const std::size_t width = mesh.vertices.size() * kFeatureDim;
        return std::span(set.features).subspan(at(shape) * width, width);
    }
    void improve() {
        MemoryRows rows(set);
        improve_from_neighbors(graph, rows, summaries, [this] { ++calls; });
    }

    TriangleMesh mesh;
    ConsistencyGraph graph;
    Vectors right, wrong;
    FeatureSet set;
    std::vector<ConsistencySummary> summaries;
    std::atomic<int> calls{0};
};

// A good choice of turns spreads from one shape to all that are like it, both ways.
TEST(NeighborStarts, SpreadTheBestTurns) {
    for (const int good : {0, kShapes / 2, kShapes - 1}) {
        Copies copies({good});
        const double best = energy_of(copies.graph, copies.right);
        EXPECT_GT(energy_of(copies.graph, copies.wrong), 2 * best);
        copies.improve();
        for (int n = 0; n < kShapes; ++n) {
            EXPECT_NEAR(copies.summaries[at(n)].energy, best, 1e-3) << good << " " << n;
            EXPECT_NEAR(energy_of(copies.graph, rotation_vectors_of(copies.row(n))), best, 1e-3);
        }
        EXPECT_GE(copies.calls, kShapes);
    }
}

TEST(NeighborStarts, LeaveProvedShapesAlone) {
    Copies copies({3});
    for (ConsistencySummary& summary : copies.summaries) summary.lower_bound = summary.energy;
    const std::vector<float> before = copies.set.features;
    copies.improve();
    EXPECT_EQ(copies.set.features, before);
    EXPECT_EQ(copies.calls, kShapes);
}

TEST(NeighborStarts, AreTheSameForAnyNumberOfThreads) {
    std::vector<std::vector<float>> results;
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        Copies copies({2, 5});
        copies.improve();
        results.push_back(copies.set.features);
    }
    set_thread_count(0);
    EXPECT_EQ(results[1], results[0]);
    EXPECT_EQ(results[2], results[0]);
}

}  // namespace
}  // namespace mscomp
