// SPDX-License-Identifier: MIT
#include "acap/turns/neighbor_starts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "acap/shape_extraction.h"
#include "acap_cases.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::ElementsAre;

using Vectors = std::vector<Vector3d>;

/// Shapes of one vertex whose r_x stands for their turns, the lower the better, and a trial that
/// takes over what is better: what spreads where can then be told in advance.
struct Chain {
    explicit Chain(const std::vector<double>& values) : summaries(values.size()) {
        graph.rings.offsets = {0, 0};
        set.names.resize(values.size());
        set.reference.vertices.resize(1);
        for (std::size_t n = 0; n < values.size(); ++n) {
            set.features.push_back(static_cast<float>(values[n]));
            set.features.insert(set.features.end(), kFeatureDim - 1, 0.25F);
            summaries[n].energy = values[n];
        }
    }
    std::vector<double> improved() {
        MemoryRows rows(set);
        improve_from_neighbors(
            graph, rows, summaries, [this] { ++visits; },
            [this](const ConsistencyGraph&, const Vectors& start, Vectors& r,
                   ConsistencySummary& summary) {
                ++trials;
                EXPECT_EQ(r[0].x(), summary.energy);
                if (start[0].x() >= r[0].x()) return false;
                r = start;
                summary.energy = start[0].x();
                return true;
            });
        std::vector<double> values;
        for (int n = 0; n < set.shape_count(); ++n) {
            values.push_back(set.shape(n)[0]);
            EXPECT_EQ(set.shape(n)[3], 0.25F);  // S stays
            EXPECT_EQ(summaries[at(n)].energy, values.back());
        }
        return values;
    }

    ConsistencyGraph graph;
    FeatureSet set;
    std::vector<ConsistencySummary> summaries;
    std::atomic<int> visits{0}, trials{0};
};

class NeighborStarts : public testing::TestWithParam<int> {
  protected:
    NeighborStarts() { set_thread_count(GetParam()); }
    ~NeighborStarts() override { set_thread_count(0); }
};

// Even shapes look first, then odd ones, three times each: from an even shape on, a good choice
// gets one shape further in each turn but the first.
TEST_P(NeighborStarts, SpreadByOneShapeWithEachTurn) {
    EXPECT_THAT(Chain({1, 9, 9, 9, 9, 9, 9, 9, 9, 9}).improved(),
                ElementsAre(1, 1, 1, 1, 1, 1, 9, 9, 9, 9));
    EXPECT_THAT(Chain({9, 9, 9, 9, 9, 9, 9, 9, 9, 1}).improved(),
                ElementsAre(9, 9, 9, 1, 1, 1, 1, 1, 1, 1));
    EXPECT_THAT(Chain({9, 9, 9, 2, 9, 9, 1, 9}).improved(), ElementsAre(2, 1, 1, 1, 1, 1, 1, 1));
}

// Both neighbours of all shapes, once, where that helps nowhere.
TEST_P(NeighborStarts, AreNotTriedAgainWhereNothingChanged) {
    Chain chain({5, 5, 5, 5, 5});
    EXPECT_THAT(chain.improved(), ElementsAre(5, 5, 5, 5, 5));
    EXPECT_EQ(chain.trials, 8);
    EXPECT_EQ(chain.visits, 5);
    // 8 times at first, then only next to what changed: 2 + 2 + 2 + 1.
    Chain from_one_end({1, 9, 9, 9, 9});
    EXPECT_THAT(from_one_end.improved(), ElementsAre(1, 1, 1, 1, 1));
    EXPECT_EQ(from_one_end.trials, 15);
    Chain alone({5});
    EXPECT_THAT(alone.improved(), ElementsAre(5));
    EXPECT_EQ(alone.trials, 0);
}

TEST_P(NeighborStarts, LeaveProvedShapesAlone) {
    Chain chain({9, 1, 9});
    chain.summaries[0].lower_bound = 9;
    EXPECT_THAT(chain.improved(), ElementsAre(9, 1, 1));
}

INSTANTIATE_TEST_SUITE_P(Threads, NeighborStarts, testing::Values(1, 2, 7));

// With the real trial: a band of rings a turn too far, beside a shape where they are right.
TEST(NeighborStart, OfAShapeWithTheRightTurnsIsTaken) {
    const TriangleMesh mesh = shapes::cylinder(8, 40, 1, 30, false);
    const ConsistencyGraph graph =
        consistency_graph(one_rings_of_faces(mesh.vertex_count(), mesh.faces),
                          std::vector<double>(mesh.vertices.size(), 0.0));
    Vectors right, wrong;
    for (const Point& p : mesh.vertices) {
        right.emplace_back(0, 0, 0.6 * p[2] + 0.1);
        const bool is_in_band = p[2] > 5 && p[2] < 12;
        wrong.push_back(right.back() + Vector3d(0, 0, is_in_band ? 2 * std::numbers::pi : 0));
    }
    const auto energy = [&](const Vectors& r) {
        double sum = 0;
        for (const auto& [i, j] : graph.edges) sum += (r[at(i)] - r[at(j)]).squaredNorm();
        return sum;
    };
    ASSERT_GT(energy(wrong), 2 * energy(right));
    FeatureSet set;
    set.features.resize(2 * right.size() * kFeatureDim);
    const std::span<float> rows(set.features);
    store_rotation_vectors(right, rows.first(rows.size() / 2));
    store_rotation_vectors(wrong, rows.last(rows.size() / 2));
    std::vector<ConsistencySummary> summaries(2);
    summaries[0].energy = energy(right);
    summaries[1].energy = energy(wrong);
    MemoryRows memory(set);
    improve_from_neighbors(graph, memory, summaries, [] {});
    EXPECT_NEAR(summaries[1].energy, energy(right), 1e-3);
    EXPECT_NEAR(energy(rotation_vectors_of(rows.last(rows.size() / 2))), energy(right), 1e-3);
}

}  // namespace
}  // namespace mscomp
