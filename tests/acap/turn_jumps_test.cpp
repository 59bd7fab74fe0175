// SPDX-License-Identifier: MIT
#include "acap/turns/turn_jumps.h"

#include <gtest/gtest.h>

#include "acap/turns/turn_search.h"
#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;

double jump(const TurnProblem& problem, const TurnProblem::Turns& turns, int i, int j) {
    return (problem.rotation_vector(i, turns[at(i)]) - problem.rotation_vector(j, turns[at(j)]))
        .norm();
}

/// Of the edge alone, over all turns of its two ends in a wide window.
double smallest_jump(const TurnProblem& problem, int i, int j) {
    double smallest = std::numeric_limits<double>::infinity();
    for (int s = -6; s <= 6; ++s) {
        for (int t = -6; t <= 6; ++t) {
            const Vector3d r = problem.rotation_vector(i, s) - problem.rotation_vector(j, t);
            smallest = std::min(smallest, r.norm());
        }
    }
    return smallest;
}

// An edge that is called neither inherent nor removable costs energy, whatever else is turned: so
// say all 5^6 choices.
TEST(TurnJumps, WhatStaysCannotBeRemovedForFree) {
    const TriangleMesh mesh = all_connected(7);
    const ConsistencyGraph graph = graph_of(mesh);
    int avoidable = 0, inherent = 0;
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
        Draws draws(seed);
        const Field logs = random_logs(draws, 7, 1 + 0.05 * static_cast<double>(seed));
        const TurnProblem problem(graph, logs);
        TurnProblem::Turns turns(7, 0);
        ASSERT_TRUE(search_turns(problem, 1 << 30, turns).proved);
        const double before = problem.energy(turns);
        const LargeJumps jumps = settle_jumps(problem, turns);
        EXPECT_NEAR(problem.energy(turns), before, 1e-8);
        EXPECT_EQ(jumps.removable, 0) << "seed " << seed;
        int count = 0, above_alone = 0;
        double most = 0;
        for (const auto& [i, j] : graph.edges) {
            const double here = jump(problem, turns, i, j);
            most = std::max(most, here);
            if (here <= kPi) continue;
            ++count;
            double least = std::numeric_limits<double>::infinity();
            for_all_turns(7, -2, 2, [&, a = i, b = j](const TurnProblem::Turns& other) {
                const bool small = jump(problem, other, a, b) <= kPi;
                if (small) least = std::min(least, problem.energy(other));
            });
            EXPECT_GT(least, before + 1e-9) << "seed " << seed << ", edge " << i << " " << j;
            if (smallest_jump(problem, i, j) > kPi) ++above_alone;
        }
        EXPECT_EQ(jumps.count, count);
        EXPECT_EQ(jumps.inherent, above_alone);
        EXPECT_NEAR(jumps.largest, most, 1e-12);
        avoidable += count - above_alone;
        inherent += above_alone;
    }
    EXPECT_GT(avoidable, 10);
    EXPECT_GT(inherent, 10);
}

// A large jump that a turn removes while the energy falls does not stay.
TEST(TurnJumps, RemovesAJumpThatCostsNothingToRemove) {
    TriangleMesh mesh;  // a chain 0 - 1 - 2
    mesh.vertices.resize(3);
    mesh.faces = {{0, 1, 1}, {1, 2, 2}};
    const ConsistencyGraph graph = graph_of(mesh);
    const Field logs{Vector3d(0, 0, 1), Vector3d(0, 0, kPi), Vector3d(0, 0, 1)};
    const TurnProblem problem(graph, logs);
    TurnProblem::Turns turns{0, -1, 0};
    const LargeJumps jumps = settle_jumps(problem, turns);
    EXPECT_EQ(turns, (TurnProblem::Turns{0, 0, 0}));
    EXPECT_EQ(jumps.count, 0);
    EXPECT_NEAR(jumps.largest, kPi - 1, 1e-12);
}

// The same where only the first end of the edge is free to turn.
TEST(TurnJumps, RemovesAJumpByTurningTheFirstEnd) {
    TriangleMesh mesh;
    mesh.vertices.resize(2);
    mesh.faces = {{0, 1, 1}};
    const ConsistencyGraph graph = consistency_graph(one_rings_of_faces(2, mesh.faces), {1, 0});
    ASSERT_EQ(graph.roots, std::vector<int>{1});
    for (const int start : {-3, -1, 1, 2}) {
        const Field logs{Vector3d(0, 0, 2), Vector3d(0, 0, 1)};
        const TurnProblem problem(graph, logs);
        TurnProblem::Turns turns{start, 0};
        const LargeJumps jumps = settle_jumps(problem, turns);
        EXPECT_EQ(turns, (TurnProblem::Turns{0, 0})) << "from " << start;
        EXPECT_EQ(jumps.count, 0);
    }
}

}  // namespace
}  // namespace mscomp
