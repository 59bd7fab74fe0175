// SPDX-License-Identifier: MIT
// Turn problems small enough to try every choice.
#pragma once

#include <limits>

#include "acap/rotation.h"
#include "acap/turns/turn_problem.h"
#include "acap_cases.h"

namespace mscomp::cases {

using Field = std::vector<Vector3d>;

inline ConsistencyGraph graph_of(const TriangleMesh& mesh) {
    return consistency_graph(one_rings_of_faces(mesh.vertex_count(), mesh.faces),
                             std::vector<double>(mesh.vertices.size(), 0.0));
}

inline Field principal(const Field& r) {
    Field logs;
    for (const Vector3d& v : r) logs.push_back(rotation_log(exp_of(v)));
    return logs;
}

/// Rotations scattered around a common one.
inline Field random_logs(Draws& draws, int count, double spread) {
    const Vector3d common = 3 * draws.vector();
    Field r;
    for (int i = 0; i < count; ++i) r.push_back(common + spread * draws.vector());
    return principal(r);
}

/// All connected with all: every sign of a_i·a_j occurs in rings of three.
inline TriangleMesh all_connected(int count) {
    TriangleMesh mesh;
    mesh.vertices.resize(at(count));
    for (int a = 0; a < count; ++a) {
        for (int b = a + 1; b < count; ++b) {
            for (int c = b + 1; c < count; ++c) mesh.faces.push_back({a, b, c});
        }
    }
    return mesh;
}

/// Nearly half turns about any axes: no choice of directions makes all neighbours agree.
inline Field half_turns(Draws& draws, int count) {
    Field r;
    for (int i = 0; i < count; ++i) {
        r.push_back((std::numbers::pi - 0.3 * std::abs(draws.next())) *
                    draws.vector().normalized());
    }
    return r;
}

/// Visits every choice of turns in [lowest, highest], the first vertex held at 0.
template <class Visit>
void for_all_turns(int vertices, int lowest, int highest, const Visit& visit) {
    TurnProblem::Turns turns(at(vertices), lowest);
    turns[0] = 0;
    while (true) {
        visit(turns);
        std::size_t i = 1;
        while (i < turns.size() && turns[i] == highest) turns[i++] = lowest;
        if (i == turns.size()) return;
        ++turns[i];
    }
}

}  // namespace mscomp::cases
