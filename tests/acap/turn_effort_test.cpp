// SPDX-License-Identifier: MIT
// Where nothing fits together the work ends all the same. It is counted, never timed.
#include <gtest/gtest.h>

#include "acap/deformation_gradient.h"
#include "acap/polar.h"
#include "acap/turns/turn_jumps.h"
#include "acap/turns/turn_search.h"
#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;

constexpr std::int64_t kSearchEffort = 1000000;

/// What is begun before a limit is ended after it: minimising once more, perhaps over all copies.
std::int64_t most_overrun(const Field& logs) { return 50 * static_cast<std::int64_t>(logs.size()); }

struct Work {
    SearchResult search;
    LargeJumps jumps;
    TurnProblem::Turns turns;
};

Work work_on(const ConsistencyGraph& graph, const Field& logs) {
    const TurnProblem problem(graph, logs);
    Work work;
    work.turns.assign(logs.size(), 0);
    const double start = problem.energy(work.turns);
    work.search = search_turns(problem, kSearchEffort, work.turns);
    const double found = problem.energy(work.turns);
    EXPECT_NEAR(start + work.search.change, found, 1e-9 * start);
    work.jumps = settle_jumps(problem, work.turns);
    EXPECT_LE(problem.energy(work.turns), found + 1e-6);
    const auto most_of_jumps = 500000 + 20 * static_cast<std::int64_t>(logs.size());
    EXPECT_LE(work.search.effort, kSearchEffort + most_overrun(logs));
    EXPECT_LE(work.jumps.effort, most_of_jumps + most_overrun(logs));
    EXPECT_LE(work.jumps.inherent + work.jumps.removable, work.jumps.count);
    return work;
}

// R of a mirrored shape is a half turn about an axis that S leaves open in part: torn all over.
TEST(TurnEffort, IsLimitedOnAMirroredShape) {
    const TriangleMesh mesh = bumpy_sphere(5);
    const TriangleMesh mirrored = mapped(mesh, [](const Vector3d& p) -> Vector3d {
        return wobble({-p.x(), p.y(), p.z()});
    });
    const DeformationGradients gradients(mesh, EdgeWeights::cotangent);
    Field logs;
    for (const Matrix3d& gradient : gradients.compute(mirrored.vertices).gradients) {
        logs.push_back(rotation_log(polar_decomposition(gradient).rotation));
    }
    const Work work = work_on(graph_of(mesh), logs);
    EXPECT_GE(work.search.effort, kSearchEffort) << "nothing is hard here";
}

TEST(TurnEffort, IsLimitedOnRandomRotations) {
    const TriangleMesh mesh = shapes::icosphere(5);
    Draws draws(4);
    const Work work = work_on(graph_of(mesh), half_turns(draws, mesh.vertex_count()));
    EXPECT_FALSE(work.search.proved);
    EXPECT_LT(work.search.bound, work.search.change);
    EXPECT_GT(work.jumps.removable, 100) << "what was not examined counts as removable";
}

// Half turns about opposite directions, one a rounding apart from π: no jump is above π.
TEST(TurnJumps, AJumpOfPiIsNotLarge) {
    TriangleMesh mesh;
    mesh.vertices.resize(2);
    mesh.faces = {{0, 1, 1}};
    const double pi = std::numbers::pi;
    for (const double rounding : {-3e-7, 0.0, 3e-7}) {
        const Field logs{Vector3d(0, 0, 0.5 * pi), Vector3d(0, 0, 0.5 * pi + rounding)};
        Field opposite = logs;
        opposite[1] *= -1;
        TurnProblem::Turns turns{0, 0};
        const ConsistencyGraph graph = graph_of(mesh);
        EXPECT_EQ(settle_jumps(TurnProblem(graph, opposite), turns).count, 0) << rounding;
        EXPECT_EQ(turns, (TurnProblem::Turns{0, 0}));
    }
}

}  // namespace
}  // namespace mscomp
