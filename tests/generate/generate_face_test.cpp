// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>

#include "dense.h"
#include "generated_cases.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

const GeneratedSequence& face() {
    static const GeneratedSequence generated = generate_face();
    return generated;
}

bool is_jaw(int component) {
    return face().component_names[static_cast<std::size_t>(component)].starts_with("jaw");
}

TEST(Face, IsATopologicalSphereTurnedOutwards) {
    EXPECT_TRUE(is_oriented_manifold(face().sequence.faces));
    EXPECT_EQ(boundary_edges(face().sequence.faces), 0);
    EXPECT_EQ(euler_characteristic(face().sequence), 2);
    EXPECT_GT(volume(face().sequence.shapes[0], face().sequence.faces), 0.5);
    EXPECT_EQ(face().sequence.vertex_count(), 10 * 18 * 18 + 2);  // the first above 3000
    EXPECT_EQ(generate_face(2, 0, 102).sequence.vertex_count(), 10 * 4 * 4 + 2);
}

// The first frame is the reference: mirrored left and right, with its weights 0.
TEST(Face, StartsWithASymmetricReference) {
    for (int k = 0; k < face().component_count(); ++k) EXPECT_EQ(weight(face(), 0, k), 0);
    for (const Point& p : face().sequence.shapes[0]) {
        double off = 0;
        nearest_vertex(face(), {-p[0], p[1], p[2]}, off);
        ASSERT_LE(off, 1e-9);
    }
}

TEST(Face, HasNoFlatTriangleAndDoesNotFoldOver) {
    for (const std::uint64_t seed : {0, 1, 2, 3}) {
        const GeneratedSequence g = generate_face(24, seed);
        for (const auto& shape : g.sequence.shapes) {
            const std::vector<double> sizes = areas(shape, g.sequence.faces);
            EXPECT_GE(*std::ranges::min_element(sizes), 0.1 * mean(sizes)) << "seed " << seed;
            EXPECT_GT(least_fold_cosine(shape, g.sequence.faces), 0) << "seed " << seed;
        }
    }
}

TEST(Face, MovesItsComponentsIndependently) {
    EXPECT_TRUE(largest_correlation(face()) <= 1e-5) << largest_correlation(face());
}

TEST(Face, HasSupportsAtTwoScales) {
    double mean_coarse = 0, mean_fine = 0, coarse = 0, fine = 0;
    for (int k = 0; k < face().component_count(); ++k) {
        EXPECT_GT(highest_support(face(), k), 0.9)
            << face().component_names[static_cast<std::size_t>(k)];
        const double share = support_share(face(), k);
        EXPECT_GT(share, 0.005);
        EXPECT_LT(share, 0.5);
        const bool is_coarse = face().scales[static_cast<std::size_t>(k)] == 0;
        (is_coarse ? mean_coarse : mean_fine) += share;
        (is_coarse ? coarse : fine) += 1;
    }
    EXPECT_GT(mean_coarse / coarse, 2 * mean_fine / fine);
}

// Every component shares vertices with another one.
TEST(Face, HasOverlappingSupports) {
    for (int k = 0; k < face().component_count(); ++k) {
        int shared = 0;
        for (int i = 0; i < face().sequence.vertex_count(); ++i) {
            int others = 0;
            for (int l = 0; l < face().component_count(); ++l) {
                others += l != k && support(face(), l, i) > 0 ? 1 : 0;
            }
            shared += support(face(), k, i) > 0 && others > 0 ? 1 : 0;
        }
        EXPECT_GT(shared, 10) << face().component_names[static_cast<std::size_t>(k)];
    }
}

TEST(Face, StandsStillOutsideTheSupports) {
    int still = 0;
    for (int i = 0; i < face().sequence.vertex_count(); ++i) {
        float reach = 0;
        for (int k = 0; k < face().component_count(); ++k) reach += support(face(), k, i);
        if (reach > 0) continue;
        ++still;
        const auto at = static_cast<std::size_t>(i);
        for (const auto& shape : face().sequence.shapes) {
            EXPECT_EQ(shape[at], face().sequence.shapes[0][at]);
        }
    }
    EXPECT_GT(still, 500);
}

// Away from the jaw a position is linear in the weights of the components that reach it: the
// displacements of all frames are explained by them without a remainder, by no fewer, and by an
// amount that is in proportion to the support.
TEST(Face, IsWhatItsWeightsAndSupportsSay) {
    const int N = face().sequence.shape_count(), K = face().component_count();
    Eigen::MatrixXd weights(N, K);
    for (int n = 0; n < N; ++n) {
        for (int k = 0; k < K; ++k) weights(n, k) = static_cast<double>(weight(face(), n, k));
    }
    const int V = face().sequence.vertex_count();
    Eigen::MatrixXd moved(N, 3 * V);
    for (int n = 0; n < N; ++n) {
        for (int i = 0; i < V; ++i) {
            const auto at = static_cast<std::size_t>(i);
            const Point by = minus(face().sequence.shapes[static_cast<std::size_t>(n)][at],
                                   face().sequence.shapes[0][at]);
            for (int x = 0; x < 3; ++x) moved(n, 3 * i + x) = by[static_cast<std::size_t>(x)];
        }
    }
    const Eigen::MatrixXd all = least_squares(weights, moved), rest = unexplained(weights, moved);
    Eigen::VectorXd highest = Eigen::VectorXd::Zero(K), lowest = Eigen::VectorXd::Constant(K, 1e9);
    for (int i = 0; i < V; ++i) {
        if (support(face(), 0, i) > 0) continue;  // the jaw's
        ASSERT_LE(rest.middleCols<3>(3 * i).cwiseAbs().maxCoeff(), 1e-9) << "vertex " << i;
        const Eigen::MatrixXd found = all.middleCols<3>(3 * i);
        for (int k = 0; k < K; ++k) {
            const double reach = static_cast<double>(support(face(), k, i));
            if (reach == 0) {
                ASSERT_LE(found.row(k).norm(), 1e-9);
            } else if (reach > 0.05) {
                highest[k] = std::max(highest[k], found.row(k).norm() / reach);
                lowest[k] = std::min(lowest[k], found.row(k).norm() / reach);
            }
        }
    }
    for (int k = 0; k < K; ++k) {
        if (is_jaw(k) || highest[k] == 0) continue;
        EXPECT_GT(lowest[k], 0.02) << face().component_names[static_cast<std::size_t>(k)];
        EXPECT_LT(highest[k], 0.15) << face().component_names[static_cast<std::size_t>(k)];
        EXPECT_LE(highest[k], 1.5 * lowest[k]);
    }
}

// At the tip of the chin, where the jaw's share is 1, the distance to the axis through the ears
// stays when it opens, and it goes down.
TEST(Face, OpensItsJaw) {
    const int jaw = component_named(face(), "jaw_open");
    int chin = 0;
    for (int i = 0; i < face().sequence.vertex_count(); ++i) {
        const auto& rest = face().sequence.shapes[0];
        float others = 0;
        for (int k = 0; k < face().component_count(); ++k) {
            if (!is_jaw(k)) others += support(face(), k, i);
        }
        const bool ahead =
            rest[static_cast<std::size_t>(i)][2] > rest[static_cast<std::size_t>(chin)][2];
        if (others == 0 && support(face(), jaw, i) == 1 && (chin == 0 || ahead)) chin = i;
    }
    ASSERT_NE(chin, 0);
    const Point rest = face().sequence.shapes[0][static_cast<std::size_t>(chin)];
    const Point joint{0, -0.05, 0};
    for (int n = 1; n < face().sequence.shape_count(); ++n) {
        const Point moved =
            face().sequence.shapes[static_cast<std::size_t>(n)][static_cast<std::size_t>(chin)];
        EXPECT_NEAR(norm(minus(moved, joint)), norm(minus(rest, joint)), 1e-9);
        if (weight(face(), n, jaw) > 0.5F) {
            EXPECT_LT(moved[1], rest[1]);
        }
    }
}

TEST(Face, DeformsAlikeAtAnyResolution) {
    const GeneratedSequence a = generate_face(5, 2, 1002);
    const GeneratedSequence b = generate_face(5, 2, 4002);  // every second point of it is in `a`
    for (int i = 0; i < a.sequence.vertex_count(); i += 7) {
        double off = 0;
        const int j = nearest_vertex(b, a.sequence.shapes[0][static_cast<std::size_t>(i)], off);
        ASSERT_LE(off, 1e-9);
        for (std::size_t n = 0; n < 5; ++n) {
            // Only the normals depend on the mesh.
            EXPECT_LE(norm(minus(a.sequence.shapes[n][static_cast<std::size_t>(i)],
                                 b.sequence.shapes[n][static_cast<std::size_t>(j)])),
                      0.01);
        }
    }
}

TEST(Face, IsAFunctionOfItsSeedForAnyNumberOfThreads) {
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(generate_face().sequence.shapes, face().sequence.shapes) << threads;
    }
    set_thread_count(0);
    EXPECT_NE(generate_face(60, 1).sequence.shapes[30], face().sequence.shapes[30]);
}

TEST(Face, RefusesTooLittle) {
    EXPECT_THROW(generate_face(1), UsageError);
    EXPECT_THROW(generate_face(60, 0, 99), UsageError);
}

}  // namespace
}  // namespace mscomp
