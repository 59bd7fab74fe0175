// SPDX-License-Identifier: MIT
// Rotations to what they turn by along edges, and back.
#include "units/turn_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "acap/rotation.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Two spheres beside each other and a vertex of no face.
TriangleMesh three_pieces() {
    TriangleMesh mesh = shapes::icosphere(2);
    const TriangleMesh other = shapes::icosphere(1);
    const int first = mesh.vertex_count();
    for (const Point& p : other.vertices) mesh.vertices.push_back({p[0] + 3, p[1], p[2]});
    for (const Face& f : other.faces) {
        mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    }
    mesh.vertices.push_back({0, 9, 0});
    return mesh;
}

/// Rotation vectors that twist about an axis by up to `most` radians, and bend a little.
std::vector<float> twisted(const TriangleMesh& mesh, double most) {
    std::vector<float> vectors;
    for (const Point& p : mesh.vertices) {
        const Eigen::Vector3f r =
            (most * p[2] * Vector3d(0.6, 0, 0.8) + Vector3d(0.3 * p[0], 0.2 * p[1], 0))
                .cast<float>();
        vectors.insert(vectors.end(), r.begin(), r.end());
    }
    return vectors;
}

std::vector<Vector3d> turns_in(const TurnField& field, std::span<const float> vectors) {
    const std::vector<float> turns = field.turns_of(vectors);
    std::vector<Vector3d> result;
    for (std::size_t e = 0; e < turns.size(); e += 3) {
        result.push_back(Eigen::Map<const Eigen::Vector3f>(turns.data() + e).cast<double>());
    }
    return result;
}

std::vector<Vector3d> vectors_at(std::span<const float> vectors, const std::vector<int>& which) {
    std::vector<Vector3d> result;
    for (const int v : which) {
        result.push_back(
            Eigen::Map<const Eigen::Vector3f>(vectors.data() + 3 * at(v)).cast<double>());
    }
    return result;
}

std::vector<Vector3d> with_noise(std::vector<Vector3d> turns, double size, std::uint64_t stream) {
    const CounterRandom random(4, stream);
    for (std::size_t i = 0; i < 3 * turns.size(); ++i) {
        turns[i / 3][static_cast<Eigen::Index>(i % 3)] += size * random.normal(i);
    }
    return turns;
}

// More than one turn, several pieces and a vertex without an edge: the same vectors come back.
TEST(TurnField, GivesTheRotationsOfShapesBack) {
    const TriangleMesh mesh = three_pieces();
    for (const double most : {0.0, 0.5, 4.5}) {
        const std::vector<float> vectors = twisted(mesh, most);
        for (const std::vector<int>& roots :
             {std::vector<int>{},
              std::vector<int>{17, mesh.vertex_count() - 3, mesh.vertex_count() - 1}}) {
            const TurnField field(mesh, roots);
            ASSERT_EQ(field.roots().size(), 3U);
            const auto found =
                field.integrated(turns_in(field, vectors), vectors_at(vectors, field.roots()));
            for (int v = 0; v < mesh.vertex_count(); ++v) {
                const Vector3d truth = vectors_at(vectors, {v}).front();
                EXPECT_LT((found[at(v)] - truth).norm(), 2e-5) << most << ", vertex " << v;
            }
        }
    }
}

// At the least squares what is left along the edges of a vertex adds up to nothing.
TEST(TurnField, TurnsThatFitNowhereAreSharedOut) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const TurnField field(mesh);
    const std::vector<float> vectors = twisted(mesh, 1);
    const auto turns = with_noise(turns_in(field, vectors), 0.002, 1);
    const auto found = field.integrated(turns, vectors_at(vectors, field.roots()));
    std::vector<Vector3d> sums(found.size(), Vector3d::Zero());
    std::vector<double> sizes(found.size(), 0.0);
    for (std::size_t e = 0; e < turns.size(); ++e) {
        const auto [i, j] = field.edges()[e];
        const Vector3d left = rotation_log(rotation_exp(found[at(i)]) * rotation_exp(turns[e]) *
                                           rotation_exp(found[at(j)]).transpose());
        sums[at(i)] += left;
        sums[at(j)] -= left;
        sizes[at(i)] += left.norm();
        sizes[at(j)] += left.norm();
    }
    for (std::size_t v = 0; v < sums.size(); ++v) {
        EXPECT_LT(sums[v].norm(), v == at(field.roots()[0]) ? 1 : 0.05 * sizes[v]) << v;
    }
}

// What the tree and the roots leave behind after one correction is gone after two.
TEST(TurnField, TurnsThatFitNowhereEndInTheSameShapeFromAnyRoot) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const std::vector<float> vectors = twisted(mesh, 1);
    std::vector<std::vector<Vector3d>> found;
    for (const int root : {0, 77}) {
        const TurnField field(mesh, {root});
        const auto turns = with_noise(turns_in(field, vectors), 0.02, 1);
        found.push_back(field.integrated(turns, vectors_at(vectors, field.roots())));
    }
    // As the second sees it: by the rotation that brings one vertex there.
    const auto back = [&](std::size_t n, std::size_t v) {
        return Matrix3d(rotation_exp(found[n][0]).transpose() * rotation_exp(found[n][v]));
    };
    double most = 0;
    for (std::size_t v = 0; v < found[0].size(); ++v) {
        most = std::max(most, rotation_log(back(0, v).transpose() * back(1, v)).norm());
    }
    EXPECT_LT(most, 2e-4) << "of turns that are off by 0.02 each";
}

// A takes small turns back to the rotations that they are of, less their mean over each piece.
TEST(TurnField, SmallTurnsAddUpToTheRotationsTheyAreOf) {
    const TriangleMesh mesh = three_pieces();
    const TurnField field(mesh, {17, 170, mesh.vertex_count() - 1});
    const auto truth =
        with_noise(std::vector<Vector3d>(at(mesh.vertex_count()), Vector3d::Zero()), 1, 1);
    std::vector<Vector3d> turns;
    for (const auto& [i, j] : field.edges()) turns.push_back(truth[at(j)] - truth[at(i)]);
    const auto found = field.added_up(turns);
    for (const std::vector<int>& piece : field.pieces()) {
        Vector3d mean = Vector3d::Zero();
        for (const int v : piece) mean += truth[at(v)] / static_cast<double>(piece.size());
        for (const int v : piece) {
            EXPECT_LT((found[at(v)] - truth[at(v)] + mean).norm(), 1e-9) << v;
        }
    }
}

TEST(TurnField, SharingOutIsTheAdjointOfAddingUp) {
    const TriangleMesh mesh = three_pieces();
    const TurnField field(mesh);
    const auto x =
        with_noise(std::vector<Vector3d>(at(field.edge_count()), Vector3d::Zero()), 1, 1);
    const auto y =
        with_noise(std::vector<Vector3d>(at(mesh.vertex_count()), Vector3d::Zero()), 1, 2);
    const auto dot = [](const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
        return sum;
    };
    const double wanted = dot(field.added_up(x), y);
    EXPECT_NEAR(dot(x, field.shared_out(y)), wanted, 1e-9 * std::abs(wanted));
    EXPECT_GT(std::abs(wanted), 0.01);
}

TEST(TurnField, DerivativesAreThoseOfDifferences) {
    const TriangleMesh mesh = three_pieces();
    const TurnField field(mesh);
    const std::vector<float> vectors = twisted(mesh, 2);
    const auto turns = with_noise(turns_in(field, vectors), 0.05, 1);
    const auto roots = vectors_at(vectors, field.roots());
    std::vector<TurnField::Direction> directions;
    for (std::uint64_t d = 0; d < 2; ++d) {
        directions.push_back(
            {with_noise(std::vector<Vector3d>(turns.size(), Vector3d::Zero()), 1, 2 + d),
             with_noise(std::vector<Vector3d>(roots.size(), Vector3d::Zero()), 1, 5 + d)});
    }
    const auto changes = field.derivatives(turns, roots, directions);
    ASSERT_EQ(changes.size(), 2U);
    constexpr double kStep = 1e-5;
    for (std::size_t d = 0; d < 2; ++d) {
        const auto moved = [&](double step) {
            std::vector<Vector3d> there = turns, root = roots;
            for (std::size_t e = 0; e < there.size(); ++e)
                there[e] += step * directions[d].turns[e];
            for (std::size_t p = 0; p < root.size(); ++p) root[p] += step * directions[d].roots[p];
            return field.integrated(there, root);
        };
        const auto up = moved(kStep), down = moved(-kStep);
        for (std::size_t v = 0; v < up.size(); ++v) {
            const Vector3d wanted = (up[v] - down[v]) / (2 * kStep);
            EXPECT_LT((changes[d][v] - wanted).norm(), 1e-6 * (1 + wanted.norm())) << v;
        }
    }
}

TEST(TurnField, RootsAreOneOfEachPiece) {
    const TriangleMesh mesh = three_pieces();
    const int last = mesh.vertex_count() - 1;
    EXPECT_THROW(TurnField(mesh, {0, last}), UsageError) << "none in the second sphere";
    EXPECT_THROW(TurnField(mesh, {0, 1, last - 1, last}), UsageError) << "two in the first";
    EXPECT_THROW(TurnField(mesh, {0, last - 1, last + 1}), UsageError) << "of no vertex";
    const TurnField field(mesh, {5, last - 1, last});
    std::vector<std::size_t> sizes;
    for (const auto& piece : field.pieces()) sizes.push_back(piece.size());
    EXPECT_EQ(sizes, (std::vector<std::size_t>{162, 42, 1}));
}

}  // namespace
}  // namespace mscomp
