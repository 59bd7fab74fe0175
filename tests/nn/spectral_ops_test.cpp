// SPDX-License-Identifier: MIT
#include "nn/spectral_ops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "op_table.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

// ---- the straight-through operator, against its definition -------------------------------------

/// Omega of one component on six vertices in a line, lengths 5 1 2 3 4 6 at distances 0 .. 1 in
/// steps of 0.2 from the last, whose length is the largest.
struct LineOfSix {
    LineDistances distances{6};
    ComponentCenters<double> centers{distances, CenterRule::follow};
    Tape<double> tape;
    Var weights = tape.input("C", {1, 1, 6, 9}, true), ranges = tape.input("d", {1}, true);
    Var omega;

    LineOfSix(double range, StraightThrough kind, bool differentiable = true) {
        const double lengths[6] = {5, 1, 2, 3, 4, 6};
        for (std::size_t v = 0; v < 6; ++v) {
            tape.value(weights)[v * 9 + 2] = 0.6 * lengths[v];
            tape.value(weights)[v * 9 + 7] = -0.8 * lengths[v];
        }
        tape.value(ranges)[0] = range;
        omega = learned_sparsity(tape, weights, ranges, centers, kind, differentiable);
        tape.forward();
        tape.backward(omega);
    }
};

// Outside 0.5 of vertex 5 lie vertices 0, 1, 2: Omega = 5 + 1 + 2, and dOmega/dd = -(5 + 1 + 2).
TEST(StraightThrough, SlopeIsMinusTheLengthsOutside) {
    LineOfSix line(0.5, StraightThrough::outside);
    EXPECT_EQ(line.centers.centers(), std::vector<int>{5});
    EXPECT_NEAR(line.tape.value(line.omega)[0], 8, 1e-12);
    EXPECT_NEAR(line.tape.grad(line.ranges)[0], -8, 1e-12);
}

// With the identity all lengths count, 5 + 1 + 2 + 3 + 4 + 6, while the value stays.
TEST(StraightThrough, SlopeOfTheIdentityIsMinusAllLengths) {
    LineOfSix line(0.5, StraightThrough::identity);
    EXPECT_NEAR(line.tape.value(line.omega)[0], 8, 1e-12);
    EXPECT_NEAR(line.tape.grad(line.ranges)[0], -21, 1e-12);
}

// A vertex exactly at the range is inside ([B] eq. 7: d_ik <= d_k gives 0).
TEST(StraightThrough, TheRangeItselfIsInside) {
    LineOfSix line(1.0, StraightThrough::outside);
    EXPECT_EQ(line.tape.value(line.omega)[0], 0);
    EXPECT_EQ(line.tape.grad(line.ranges)[0], 0);
}

// For the proximal step the component weights get no slope, the ranges keep theirs.
TEST(StraightThrough, RangesLearnInAProximalRunToo) {
    LineOfSix line(0.5, StraightThrough::outside, false);
    EXPECT_NEAR(line.tape.grad(line.ranges)[0], -8, 1e-12);
    for (const double g : line.tape.grad(line.weights)) EXPECT_EQ(g, 0);
}

// A centre that settles moves to the longest vertex only where less of the component lies outside
// from there; one that follows always does.
TEST(ComponentCenters, SettleWhereThePenaltyIsLower) {
    LineDistances distances(6);  // 0.2 apart
    const std::vector<double> range{0.3};
    const auto centers_after = [&](CenterRule rule, const std::vector<double>& then) {
        ComponentCenters<double> centers(distances, rule);
        for (const std::vector<double>& lengths : {std::vector<double>{0, 0, 0, 0, 0, 1}, then}) {
            centers.focus(lengths, 1, range);  // one channel: the weights are the lengths
        }
        return centers.centers();
    };
    const std::vector<double> bulk_stays{3, 0, 0, 0, 2, 2}, bulk_moves{3, 2, 0, 0, 0, 2};
    EXPECT_EQ(centers_after(CenterRule::settle, bulk_stays), std::vector<int>{5});
    EXPECT_EQ(centers_after(CenterRule::settle, bulk_moves), std::vector<int>{0});
    EXPECT_EQ(centers_after(CenterRule::follow, bulk_stays), std::vector<int>{0});
}

// ---- the scaled Laplacian -----------------------------------------------------------------------

OneRings circle(int count) {
    OneRings rings;
    for (int v = 0; v < count; ++v) {
        const int before = (v + count - 1) % count, after = (v + 1) % count;
        rings.neighbors.push_back(std::min(before, after));
        rings.neighbors.push_back(std::max(before, after));
        rings.offsets.push_back(2 * (v + 1));
    }
    return rings;
}

// On a circle of n vertices the eigenvectors are waves: L w_f = (1 - cos(2 pi f / n)) w_f. So with
// lambda_max = 2, T_h(L~) w_f = T_h(-cos(2 pi f / n)) w_f = cos(h (pi - 2 pi f / n)) w_f.
TEST(ScaledLaplacian, ChebyshevTermsOfAWaveAreItsCosines) {
    constexpr int kCount = 12, kRow = 8;
    const ScaledLaplacian<double> laplacian(circle(kCount), {}, LambdaMax::two);
    for (const int frequency : {0, 1, 5, 6}) {
        const double angle = 2 * std::numbers::pi * frequency / kCount;
        AlignedVector<double> before(kCount * kRow), now(kCount * kRow), next(kCount * kRow);
        for (int v = 0; v < kCount; ++v) {
            for (int i = 0; i < kRow; ++i) {
                now[static_cast<std::size_t>(v * kRow + i)] = std::cos(angle * v);
            }
        }
        for (int degree = 1; degree <= 4; ++degree) {
            laplacian.next_term(degree, now.data(), before.data(), kRow, 0, kCount, next.data());
            const double factor = std::cos(degree * (std::numbers::pi - angle));
            for (int v = 0; v < kCount; ++v) {
                EXPECT_NEAR(next[static_cast<std::size_t>(v * kRow)], factor * std::cos(angle * v),
                            1e-12);
            }
            std::swap(before, now);
            std::swap(now, next);
        }
    }
}

// Largest eigenvalues known in closed form: 2 on an even circle, 1 + cos(pi / 9) on one of nine
// vertices, 4/3 on the tetrahedron's complete graph.
TEST(ScaledLaplacian, ExactLambdaMaxIsTheLargestEigenvalue) {
    const auto exact = [](const OneRings& rings) {
        return ScaledLaplacian<double>(rings, {}, LambdaMax::exact).lambda_max();
    };
    EXPECT_NEAR(exact(circle(200)), 2, 1e-12);
    EXPECT_NEAR(exact(circle(9)), 1 + std::cos(std::numbers::pi / 9), 1e-12);
    EXPECT_NEAR(exact(one_rings_of_faces(4, {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}})), 4.0 / 3,
                1e-12);
}

// The constant times D^1/2 is in the kernel of L, so L~ maps it to its negative, whatever the
// weights of the edges.
TEST(ScaledLaplacian, RootOfTheDegreesIsInTheKernelForAnyWeights) {
    const TriangleMesh mesh = shapes::grid(5, 4);
    const OneRings rings = one_rings_of_faces(20, mesh.faces);
    std::vector<double> weights, degrees(20, 0.0);
    for (int v = 0; v < 20; ++v) {
        for (int at = rings.offsets[static_cast<std::size_t>(v)];
             at < rings.offsets[static_cast<std::size_t>(v) + 1]; ++at) {
            const int n = rings.neighbors[static_cast<std::size_t>(at)];
            weights.push_back(1 + 0.1 * (v + n) + (v * n) % 3);
            degrees[static_cast<std::size_t>(v)] += weights.back();
        }
    }
    for (const LambdaMax lambda_max : {LambdaMax::two, LambdaMax::exact}) {
        const ScaledLaplacian<double> laplacian(rings, weights, lambda_max);
        AlignedVector<double> x(20 * 8), y(20 * 8);
        for (std::size_t i = 0; i < x.size(); ++i) x[i] = std::sqrt(degrees[i / 8]);
        laplacian.apply(x.data(), 8, 1.0, nullptr, 0, 20, y.data());
        for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(y[i], -x[i], 1e-12);
    }
}

// ---- the divergence -----------------------------------------------------------------------------

// KL(N(mu, sigma^2) | N(0, 1)) of one code: 0 for the prior itself, mu^2 / 2 for a shifted one, and
// (sigma^2 - 1 - ln sigma^2) / 2 for a wider one; the same by either parametrisation of sigma.
TEST(KlDivergence, IsThatOfTwoGaussians) {
    const auto kl = [](double mu, double sigma, Spread spread) {
        Tape<double> tape;
        LaneMask<double> lanes{1, {1, 0, 0, 0, 0, 0, 0, 0}};
        const Var moments = tape.input("moments", {2, 1, 8}, true);
        tape.value(moments)[0] = mu;
        tape.value(moments)[8] = spread == Spread::linear ? sigma : 2 * std::log(sigma);
        const Var result = kl_divergence(tape, moments, spread, 0.0, lanes);
        tape.forward();
        return tape.value(result)[0];
    };
    for (const Spread spread : {Spread::log_variance, Spread::linear}) {
        EXPECT_NEAR(kl(0, 1, spread), 0, 1e-15);
        EXPECT_NEAR(kl(3, 1, spread), 4.5, 1e-14);
        EXPECT_NEAR(kl(0, std::numbers::e, spread), (std::exp(2.0) - 3) / 2, 1e-14);
    }
}

}  // namespace
}  // namespace mscomp::nn
