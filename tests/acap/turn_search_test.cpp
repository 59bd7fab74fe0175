// SPDX-License-Identifier: MIT
#include "acap/turns/turn_search.h"

#include <gtest/gtest.h>

#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;

/// Least energy over all turns in {-2, ..., 2}, tried one by one.
double brute_force(const TurnProblem& problem) {
    double least = std::numeric_limits<double>::infinity();
    for_all_turns(problem.vertex_count(), -2, 2, [&](const TurnProblem::Turns& turns) {
        least = std::min(least, problem.energy(turns));
    });
    return least;
}

// What is called proved is the least of all 5^6 choices; a bound is never above it, early or late.
TEST(TurnSearch, ProvedMeansLeastAndBoundsAreNotAboveIt) {
    const TriangleMesh mesh = all_connected(7);
    const ConsistencyGraph graph = graph_of(mesh);
    int branched = 0, improved = 0, open = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        Draws draws(seed);
        const Field logs = seed % 2 == 0
                               ? random_logs(draws, 7, 0.8 + 0.1 * static_cast<double>(seed % 30))
                               : half_turns(draws, 7);
        const TurnProblem problem(graph, logs);
        const double least = brute_force(problem);
        const double start = problem.energy(TurnProblem::Turns(7, 0));
        for (const int effort : {1, 40, 80, 1 << 30}) {
            TurnProblem::Turns turns(7, 0);
            const SearchResult result = search_turns(problem, effort, turns);
            EXPECT_NEAR(start + result.change, problem.energy(turns), 1e-9);
            EXPECT_LE(start + result.bound, least + 1e-8) << "seed " << seed;
            EXPECT_LE(result.bound, result.change);
            EXPECT_LE(result.change, 0);
            if (result.proved) {
                EXPECT_NEAR(start + result.change, least, 1e-8) << "seed " << seed;
            }
            if (effort == 1 && !result.proved) ++open;
            if (effort < 1 << 30) continue;
            EXPECT_TRUE(result.proved);
            if (result.visited > 1) ++branched;
            if (result.change < -1e-6) ++improved;
        }
    }
    EXPECT_GT(open, 5);
    EXPECT_GT(branched, 5);
    EXPECT_GT(improved, 20);
}

// The region beyond the cut carries one common jump: no single vertex can mend it, a cluster can.
TEST(TurnSearch, ClustersMoveWhereSingleVerticesCannot) {
    const TriangleMesh mesh = shapes::grid(12, 6);
    const ConsistencyGraph graph = graph_of(mesh);
    const Field logs(mesh.vertices.size(), Vector3d(0, 0, 1));
    const TurnProblem problem(graph, logs);
    TurnProblem::Turns turns(logs.size(), 0);
    for (std::size_t i = 0; i < turns.size(); ++i) turns[i] = mesh.vertices[i][0] > 5 ? -1 : 0;
    const double cut = problem.energy(turns);
    EXPECT_EQ(polish_vertices(problem, turns), 0);
    const SearchResult result = search_turns(problem, 1, turns);
    EXPECT_TRUE(result.proved);
    EXPECT_NEAR(result.change, -cut, 1e-9);
    EXPECT_EQ(problem.energy(turns), 0);
}

// One edge: its minimum is the least over all pairs of turns in a wide window.
TEST(TurnProblem, MinimumOfAnEdgeIsItsLeastEnergyOverAllTurns) {
    TriangleMesh mesh;
    mesh.vertices.resize(2);
    mesh.faces = {{0, 1, 1}};
    const ConsistencyGraph pair = graph_of(mesh);
    Draws draws(9);
    for (int trial = 0; trial < 500; ++trial) {
        const double near = std::pow(10.0, -3 * std::abs(draws.next()));
        const Vector3d axis = draws.vector().normalized();
        const Vector3d other =
            (axis * (draws.next() > 0 ? 1 : -1) + near * draws.vector()).normalized();
        const double reach = std::numbers::pi * (trial % 3 == 0 ? 3 : 1);  // or beyond principal
        const Field logs{reach * std::abs(draws.next()) * axis,
                         reach * std::abs(draws.next()) * other};
        const TurnProblem problem(pair, logs);
        double least = std::numeric_limits<double>::infinity();
        for (int s = -8; s <= 8; ++s) {
            for (int t = -8; t <= 8; ++t) {
                const Vector3d r = problem.rotation_vector(0, s) - problem.rotation_vector(1, t);
                least = std::min(least, r.squaredNorm());
            }
        }
        EXPECT_NEAR(problem.edge_minimum(0, 1), least, 1e-10);
    }
}

// Change and best turn of a vertex agree with the energy itself.
TEST(TurnProblem, ChangeOfAVertexIsTheDifferenceOfEnergies) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const ConsistencyGraph graph = graph_of(mesh);
    Draws draws(3);
    const Field logs = random_logs(draws, mesh.vertex_count(), 2);
    const TurnProblem problem(graph, logs);
    TurnProblem::Turns turns(logs.size());
    for (int& turn : turns) turn = static_cast<int>(2.9 * draws.next());
    turns[0] = 0;
    const double before = problem.energy(turns);
    for (int vertex = 1; vertex < mesh.vertex_count(); ++vertex) {
        const int best = problem.best_turn(turns, vertex);
        for (int turn = -4; turn <= 4; ++turn) {
            TurnProblem::Turns other = turns;
            other[at(vertex)] = turn;
            const double change = problem.energy(other) - before;
            EXPECT_NEAR(problem.change(turns, vertex, turn), change, 1e-9);
            EXPECT_LE(problem.change(turns, vertex, best), change + 1e-9);
        }
    }
}

}  // namespace
}  // namespace mscomp
