// SPDX-License-Identifier: MIT
#include "acap/turns/consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "acap/turns/relaxed_turns.h"
#include "acap/turns/turn_search.h"
#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;

double energy(const ConsistencyGraph& graph, const Field& r) {
    double sum = 0;
    for (const auto& [i, j] : graph.edges) sum += (r[at(i)] - r[at(j)]).squaredNorm();
    return sum;
}

/// Least energy over all turns in {-1, 0, 1} with vertex 0 held: tried one by one.
double brute_force(const ConsistencyGraph& graph, const Field& logs) {
    const std::size_t free = logs.size() - 1;
    double least = std::numeric_limits<double>::infinity();
    const auto count = static_cast<long>(std::pow(3.0, static_cast<double>(free)) + 0.5);
    for (long code = 0; code < count; ++code) {
        Field r = logs;
        long rest = code;
        for (std::size_t i = 1; i <= free; ++i, rest /= 3) {
            r[i] += 2 * kPi * static_cast<double>(rest % 3 - 1) * logs[i].normalized();
        }
        least = std::min(least, energy(graph, r));
    }
    return least;
}

/// Two hexagons side by side: 10 vertices, each ring small enough for all 3^9 choices.
TriangleMesh small_mesh() { return shapes::grid(5, 2); }

// E of the result is at most E of every choice of t in {-1, 0, 1}.
TEST(Consistency, NoChoiceOfTurnsOnASmallMeshIsBetter) {
    const TriangleMesh mesh = small_mesh();
    const ConsistencyGraph graph = graph_of(mesh);
    ASSERT_EQ(graph.roots, std::vector<int>{0});
    int harder = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Draws draws(seed);
        Field r = random_logs(draws, mesh.vertex_count(), seed % 2 == 0 ? 0.8 : 2.0);
        const double least = brute_force(graph, r);
        const ConsistencySummary summary = make_consistent(graph, r);
        EXPECT_LE(summary.energy, least + 1e-9) << "seed " << seed;
        EXPECT_NEAR(summary.energy, energy(graph, r), 1e-9);
        EXPECT_LE(summary.lower_bound, least + 1e-9) << "seed " << seed;
        const double cheap = std::min(summary.principal_energy, summary.propagation_energy);
        if (least < cheap - 1e-6) ++harder;
    }
    EXPECT_GT(harder, 3) << "the cheap starts alone would pass";
}

// Whatever the rotations: never above the two cheap starts, and every r is a logarithm of its R.
TEST(Consistency, NeverWorseThanItsStartsAndAlwaysALogarithm) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const ConsistencyGraph graph = graph_of(mesh);
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Draws draws(seed);
        const Field before =
            random_logs(draws, mesh.vertex_count(), 0.2 * static_cast<double>(seed));
        Field after = before;
        const ConsistencySummary summary = make_consistent(graph, after);
        EXPECT_NEAR(summary.principal_energy, energy(graph, before), 1e-8);
        EXPECT_LE(summary.energy, summary.principal_energy);
        EXPECT_LE(summary.energy, summary.propagation_energy);
        EXPECT_LE(summary.lower_bound, summary.energy + 1e-9);
        for (std::size_t i = 0; i < after.size(); ++i) {
            ASSERT_LT(largest(exp_of(after[i]) - exp_of(before[i])), 1e-12);
        }
    }
}

// Where the search gives up, three starts are searched, and none of them alone is better.
TEST(Consistency, KeepsTheBestOfAllStarts) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const ConsistencyGraph graph = graph_of(mesh);
    int open = 0;
    for (std::uint64_t seed = 80; seed < 82; ++seed) {
        Draws draws(seed);
        Field r = half_turns(draws, mesh.vertex_count());
        const TurnProblem problem(graph, r);
        double best = std::numeric_limits<double>::infinity();
        std::array<TurnProblem::Turns, 3> starts{TurnProblem::Turns(r.size(), 0),
                                                 problem.propagated(), relaxed_turns(problem)};
        for (TurnProblem::Turns& start : starts) {
            polish_vertices(problem, start);
            best = std::min(best, problem.energy(start));
        }
        const Vector3d root = r[0];
        const ConsistencySummary summary = make_consistent(graph, r);
        EXPECT_LE(summary.energy, best + 1e-9) << "seed " << seed;
        EXPECT_LE(summary.energy, summary.relaxation_energy);
        EXPECT_EQ(r[0], root) << "the root keeps its principal logarithm";
        if (summary.energy > summary.lower_bound + 1e-6) ++open;
    }
    EXPECT_GT(open, 0) << "nothing is too hard here";
}

// Spanning the whole mesh by short steps is exact where the field is smooth.
TEST(Consistency, PropagationAloneRecoversASmoothField) {
    const TriangleMesh mesh = shapes::grid(30, 4);
    Field truth;
    for (const Point& p : mesh.vertices)
        truth.push_back((0.5 * p[0] + 0.1 * p[1]) * Vector3d::UnitX());
    const ConsistencyGraph graph = graph_of(mesh);
    const Field logs = principal(truth);
    const TurnProblem problem(graph, logs);
    const TurnProblem::Turns turns = problem.propagated();
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        ASSERT_LT(largest(problem.rotation_vector(i, turns[at(i)]) - truth[at(i)]), 1e-12);
    }
}

// Where nothing turns fully, the smallest rotations stay exactly what they are.
TEST(Consistency, SmallRotationsBesideLargeOnesAreUntouched) {
    const TriangleMesh mesh = shapes::grid(6, 6);
    Draws draws(8);
    Field r;
    for (const Point& p : mesh.vertices) {
        r.push_back(p[0] < 3 ? Vector3d(2e-5 * draws.vector()) : Vector3d(0.1, 0, p[1]) * 0.2);
    }
    const Field before = r;
    make_consistent(graph_of(mesh), r);
    EXPECT_EQ(r, before);
}

// A smooth field of several turns around one axis comes back as it was made.
TEST(Consistency, SmoothFieldOfSeveralTurnsIsRecovered) {
    const TriangleMesh mesh = shapes::grid(30, 4);
    const Vector3d axis = Vector3d(1, 2, -1).normalized();
    Field truth;
    for (const Point& p : mesh.vertices) truth.push_back((0.5 * p[0] + 0.1 * p[1]) * axis);
    Field r = principal(truth);
    const ConsistencyGraph graph = graph_of(mesh);
    ASSERT_GT(energy(graph, r), 100);
    const ConsistencySummary summary = make_consistent(graph, r);
    for (std::size_t i = 0; i < r.size(); ++i) ASSERT_LT(largest(r[i] - truth[i]), 1e-12) << i;
    EXPECT_NEAR(summary.energy, summary.lower_bound, 1e-9);
    EXPECT_NEAR(summary.largest_jump, 0.6, 1e-12);
}

// After a full turn R = I and the logarithm has lost the axis; the neighbours know it.
TEST(Consistency, FullTurnsTakeTheirAxisFromTheNeighbors) {
    const TriangleMesh mesh = shapes::grid(25, 5);
    Field truth;
    for (const Point& p : mesh.vertices) {
        const double steps = std::min(p[0], 10.0) + std::max(p[0] - 14, 0.0);  // rests at 2π
        truth.push_back(steps * kPi / 5 * Vector3d::UnitY());
    }
    Field r = principal(truth);
    for (Vector3d& v : r) {
        if (v.norm() < 1e-6) v = Vector3d(1e-12, 0, 3e-12);  // noise instead of an axis
    }
    make_consistent(graph_of(mesh), r);
    for (std::size_t i = 0; i < r.size(); ++i) ASSERT_LT(largest(r[i] - truth[i]), 1e-10) << i;
}

// At θ = π both signs of the axis are logarithms: all vertices take the same.
TEST(Consistency, HalfTurnsAgreeOnTheSignOfTheirAxis) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const Vector3d axis = Vector3d(3, -1, 2).normalized();
    Field r;
    Draws draws(5);
    for (int i = 0; i < mesh.vertex_count(); ++i)
        r.push_back((draws.next() > 0 ? kPi : -kPi) * axis);
    const Vector3d root = r[0];
    const ConsistencySummary summary = make_consistent(graph_of(mesh), r);
    EXPECT_GT(summary.principal_energy, 1000);
    for (const Vector3d& v : r) EXPECT_LT(largest(v - root), 1e-12);
}

// The relaxation of a field of equal rotations is that field.
TEST(Consistency, RelaxationKeepsAConstantField) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const ConsistencyGraph graph = graph_of(mesh);
    Field logs(mesh.vertices.size(), Vector3d(0, 3, 0));
    for (std::size_t i = 1; i < logs.size(); i += 2) logs[i] *= (3 - 2 * kPi) / 3;
    const TurnProblem problem(graph, logs);
    EXPECT_GT(problem.energy(TurnProblem::Turns(logs.size(), 0)), 1);
    EXPECT_NEAR(problem.energy(relaxed_turns(problem)), 0, 1e-20);
}

Field rounded(Field r) {
    for (Vector3d& v : r) v = v.cast<float>().cast<double>();
    return r;
}

// A start that is the answer is taken: from any turns, and never upwards.
TEST(Consistency, AStartFromTheShapeBeforeIsTakenWhereItIsBetter) {
    const TriangleMesh mesh = shapes::grid(30, 4);
    const ConsistencyGraph graph = graph_of(mesh);
    Field truth, poor;
    for (const Point& p : mesh.vertices) {
        truth.push_back((0.5 * p[0] + 0.1 * p[1]) * Vector3d(1, 2, -1).normalized());
        poor.push_back(truth.back() + (p[0] > 14 ? 2 * kPi : 0) * truth.back().normalized());
    }
    poor = rounded(poor);
    const Field before = poor;
    ConsistencySummary summary;
    summary.energy = energy(graph, poor);
    Field previous = truth;
    for (Vector3d& v : previous) v *= 0.9;
    ASSERT_TRUE(improve_consistency(graph, previous, poor, summary));
    EXPECT_NEAR(summary.energy, energy(graph, truth), 1e-4);
    EXPECT_NEAR(summary.largest_jump, 0.6, 1e-5);
    for (std::size_t i = 0; i < truth.size(); ++i) {
        ASSERT_LT(largest(poor[i] - truth[i]), 1e-5);
        if (mesh.vertices[i][0] < 14) {
            EXPECT_EQ(poor[i], before[i]);
        }
    }
    const Field found = poor;
    EXPECT_FALSE(improve_consistency(graph, before, poor, summary));
    EXPECT_EQ(poor, found);
}

TEST(Consistency, EveryComponentHasItsQuietestVertexAsRoot) {
    TriangleMesh mesh = shapes::icosphere(0);
    for (const Face& f : shapes::icosphere(0).faces)
        mesh.faces.push_back({f[0] + 12, f[1] + 12, f[2] + 12});
    for (const Point& p : shapes::icosphere(0).vertices)
        mesh.vertices.push_back({p[0] + 5, p[1], p[2]});
    std::vector<double> unrest(24, 1.0);
    unrest[3] = 0.5;
    unrest[20] = 0.25;
    unrest[17] = 0.25 + 1e-5;  // as quiet as makes no difference, and earlier
    const auto graph =
        consistency_graph(one_rings_of_faces(mesh.vertex_count(), mesh.faces), unrest);
    EXPECT_EQ(graph.roots, (std::vector<int>{3, 17}));
    EXPECT_EQ(graph.edges.size(), 60U);
}

}  // namespace
}  // namespace mscomp
