// SPDX-License-Identifier: MIT
// Every instruction set this processor has: spectral kernels against the generic ones.
#include "nn/kernels/spectral_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/aligned.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

constexpr int kGridVertices = 20, kRows = kGridVertices * 9;

template <class T>
AlignedVector<T> random_values(int count, std::uint64_t stream) {
    const CounterRandom random(18, stream);
    AlignedVector<T> values(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<T>(random.normal(i));
    return values;
}

/// Runs every kernel of a table on the same random data; returns all outputs one after the other.
template <class T>
std::vector<double> run_all(const SpectralKernels<T>& k, int lanes, int components) {
    const OneRings rings = one_rings_of_faces(kGridVertices, shapes::grid(5, 4).faces);
    const auto edges = static_cast<int>(rings.neighbors.size());
    const AlignedVector<T> x = random_values<T>(kRows * lanes, 1),
                           g = random_values<T>(kRows * lanes, 2);
    const AlignedVector<T> weights = random_values<T>(components * kRows + 1, 3);
    const AlignedVector<T> codes = random_values<T>(components * lanes, 4);
    const AlignedVector<T> theta = random_values<T>(3 * 81, 5), edge = random_values<T>(edges, 6);
    const GraphMatrix<T> matrix{kGridVertices, rings.offsets.data(), rings.neighbors.data(),
                                edge.data(), T(0.3)};
    std::vector<double> results;
    const auto keep = [&](const AlignedVector<T>& values) {
        results.insert(results.end(), values.begin(), values.end());
    };
    Ahead ahead;
    AlignedVector<T> y(x.size()), z(codes.size()), out(x.size());
    k.laplacian(matrix, x.data(), 9 * lanes, T{2}, g.data(), 0, kGridVertices, y.data());
    keep(y);
    k.laplacian(matrix, x.data(), 9 * lanes, T{1}, nullptr, 3, kGridVertices, out.data());
    keep(out);
    const T* terms[3] = {x.data(), g.data(), y.data()};
    for (const bool use_tanh : {false, true}) {
        k.filter(terms, 3, theta.data(), use_tanh, lanes, kGridVertices, out.data());
        keep(out);
    }
    AlignedVector<T> slope = g;
    k.tanh_slope(out.data(), static_cast<std::int64_t>(slope.size()), slope.data());
    keep(slope);
    AlignedVector<T> lane_weight(static_cast<std::size_t>(lanes), T{1});
    lane_weight.back() = 0;
    results.push_back(
        k.error_slope(x.data(), lane_weight.data(), T{0.5}, lanes, kGridVertices, out.data()));
    keep(out);
    AlignedVector<T> sums(81 * 16);
    k.outer_9x9(x.data(), g.data(), lanes, kGridVertices, sums.data());
    for (int i = 0; i < 81; ++i) {
        double sum = 0;
        for (int n = 0; n < 16; ++n)
            sum += static_cast<double>(sums[static_cast<std::size_t>(i * 16 + n)]);
        results.push_back(sum);
    }
    // Weights on no boundary of registers, as in a ParameterSet with an odd number of vertices.
    k.project(weights.data() + 1, kRows, components, x.data(), lanes, kRows, ahead, z.data());
    keep(z);
    k.expand(weights.data() + 1, kRows, components, codes.data(), lanes, kRows, false, ahead,
             out.data());
    k.expand(weights.data() + 1, kRows, components, codes.data(), lanes, kRows - 5, true, ahead,
             out.data());
    keep(out);
    const int padded = (components + 15) / 16 * 16, active = lanes - 3;
    AlignedVector<T> transposed = random_values<T>(lanes * padded, 7);
    AlignedVector<T> scratch(static_cast<std::size_t>(kRows * padded)), grad = weights;
    k.outer(transposed.data(), padded, components, x.data(), lanes, active, kRows, scratch.data(),
            kRows, grad.data() + 1);
    keep(grad);
    AlignedVector<T> lengths(kGridVertices), moments = random_values<T>(kRows, 8);
    for (T& m : moments) m *= m;
    for (const int channels : {9, 4}) {
        results.push_back(k.lengths(weights.data() + 1, channels, kGridVertices, lengths.data()));
        keep(lengths);
        double distances[kGridVertices];
        for (int v = 0; v < kGridVertices; ++v) distances[v] = 0.05 * v;
        results.push_back(k.outside(distances, lengths.data(), 0.3, kGridVertices));
        AlignedVector<T> shrunk = weights;
        k.shrink(moments.data(), distances, lengths.data(), 0.3, T(0.5), channels, kGridVertices,
                 shrunk.data() + 1);
        keep(shrunk);
    }
    return results;
}

class SpectralInstructionSet : public testing::TestWithParam<const char*> {};

template <class T>
void expect_like_generic(const char* name, double tolerance) {
    const SpectralKernels<T>* wide = find_spectral_kernels<T>(name);
    if (wide == nullptr) GTEST_SKIP() << "this processor has no " << name;
    ASSERT_STREQ(wide->instruction_set, name);
    for (const int lanes : {8, 16, 48, 80}) {
        for (const int components : {1, 6, 23, 50}) {
            const auto expected = run_all(*find_spectral_kernels<T>("generic"), lanes, components);
            const auto got = run_all(*wide, lanes, components);
            ASSERT_EQ(got.size(), expected.size());
            for (std::size_t i = 0; i < got.size(); ++i) {
                ASSERT_TRUE(std::abs(got[i] - expected[i]) <=
                            tolerance * (1 + std::abs(expected[i])))
                    << lanes << " lanes, " << components << " components, output " << i << ": "
                    << got[i] << " instead of " << expected[i];
            }
        }
    }
}

// Sums of at most 9 x 20 x 80 terms around 1 that cancel: in double 1e-16 each.
TEST_P(SpectralInstructionSet, AgreesWithTheGenericOneInDouble) {
    expect_like_generic<double>(GetParam(), 2e-12);
}

TEST_P(SpectralInstructionSet, AgreesWithTheGenericOneInFloat) {
    expect_like_generic<float>(GetParam(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Sets, SpectralInstructionSet, testing::Values("avx2", "avx512"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace mscomp::nn
