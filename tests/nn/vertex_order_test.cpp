// SPDX-License-Identifier: MIT
#include "nn/vertex_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/random.h"
#include "nn/start.h"
#include "shapes.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

int bandwidth(const OneRings& rings) {
    int widest = 0;
    for (int v = 0; v < rings.vertex_count(); ++v) {
        for (int at = rings.offsets[static_cast<std::size_t>(v)];
             at < rings.offsets[static_cast<std::size_t>(v) + 1]; ++at) {
            widest = std::max(widest, std::abs(rings.neighbors[static_cast<std::size_t>(at)] - v));
        }
    }
    return widest;
}

std::vector<Face> renumbered(std::vector<Face> faces, const std::vector<int>& to) {
    for (Face& face : faces) {
        for (int& v : face) v = to[static_cast<std::size_t>(v)];
    }
    return faces;
}

TEST(ReverseCuthillMcKee, IsAPermutationWithItsInverse) {
    TriangleMesh mesh = shapes::icosphere(1);
    mesh.vertices.push_back({0, 0, 9});  // a second component
    const VertexOrder order =
        reverse_cuthill_mckee(one_rings_of_faces(mesh.vertex_count(), mesh.faces));
    for (int i = 0; i < mesh.vertex_count(); ++i) {
        EXPECT_EQ(
            order.to_internal[static_cast<std::size_t>(order.to_user[static_cast<std::size_t>(i)])],
            i);
    }
}

// A strip of 3 x 60 vertices in random order comes back with neighbours no further apart than about
// a level of the breadth-first search.
TEST(ReverseCuthillMcKee, BringsNeighboursTogether) {
    const TriangleMesh mesh = shapes::grid(60, 3);
    const std::vector<int> shuffled = CounterRandom(1, 2).permutation(180);
    const OneRings rings = one_rings_of_faces(180, renumbered(mesh.faces, shuffled));
    EXPECT_GT(bandwidth(rings), 90);
    EXPECT_LE(bandwidth(reordered(rings, reverse_cuthill_mckee(rings))), 7);
}

// Reordering keeps who is whose neighbour.
TEST(ReverseCuthillMcKee, KeepsNeighbours) {
    const TriangleMesh mesh = shapes::icosphere(1);
    const OneRings rings = one_rings_of_faces(42, mesh.faces);
    const VertexOrder order = reverse_cuthill_mckee(rings);
    const OneRings direct = one_rings_of_faces(42, renumbered(mesh.faces, order.to_internal));
    const OneRings got = reordered(rings, order);
    EXPECT_EQ(got.offsets, direct.offsets);
    EXPECT_EQ(got.neighbors, direct.neighbors);
}

// Renumbering the vertices of the user renumbers the result and changes nothing else.
TEST(StackedModel, CommutesWithRenumbering) {
    SmallTraining problem;
    const auto model = problem.make_model();
    start_random(*model, 1);
    model->load_batch(std::span<const float>(problem.features),
                      std::span<const int>(problem.shapes));
    const float loss = model->forward();

    const int count = model->vertex_count();
    const std::vector<int> to = CounterRandom(4, 4).permutation(count);
    SmallTraining other;
    other.mesh.faces = renumbered(problem.mesh.faces, to);
    for (int v = 0; v < count; ++v) {
        other.mesh.vertices[static_cast<std::size_t>(to[static_cast<std::size_t>(v)])] =
            problem.mesh.vertices[static_cast<std::size_t>(v)];
    }
    SphereDistances distances(other.mesh.vertices);
    const auto move_rows = [&](std::span<const float> from) {
        std::vector<float> moved(from.size());
        for (std::size_t row = 0; row < from.size() / 9; ++row) {
            const auto v = row % static_cast<std::size_t>(count);
            const std::size_t target = row - v + static_cast<std::size_t>(to[v]);
            std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(row * 9), 9,
                        moved.begin() + static_cast<std::ptrdiff_t>(target * 9));
        }
        return moved;
    };
    StackedModel<float> renamed(other.config.stacked, other.config.loss,
                                one_rings_of_faces(count, other.mesh.faces), distances,
                                training_options(other.config, 12));
    for (int i = 0; i < model->parameters().count(); ++i) {
        std::vector<float> user =
            model->to_user_order(i, std::span<const float>(model->parameters().value(i)));
        if (model->parameters().entry(i).extents.size() == 4) user = move_rows(user);
        renamed.from_user_order(i, user, renamed.parameters().value(i));
    }
    const std::vector<float> features = move_rows(problem.features);
    renamed.load_batch(std::span<const float>(features), std::span<const int>(problem.shapes));
    EXPECT_NEAR(renamed.forward(), loss, 1e-5 * std::abs(loss));
    const std::vector<float> expected = move_rows(model->reconstruction(2));
    const std::vector<float> got = renamed.reconstruction(2);
    for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], expected[i], 1e-5);
}

}  // namespace
}  // namespace mscomp::nn
