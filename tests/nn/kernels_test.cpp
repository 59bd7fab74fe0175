// SPDX-License-Identifier: MIT
// Every instruction set this processor has against the op's naive reference or against the generic
// set.
#include "nn/kernels/kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/aligned.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/random.h"
#include "nn/ops.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

template <class T>
AlignedVector<T> random_values(std::size_t count, std::uint64_t stream) {
    const CounterRandom random(17, stream);
    AlignedVector<T> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(random.normal(i));
    return values;
}

/// Runs every kernel of a table on the same random data; returns all outputs one after the other.
template <class T>
std::vector<double> run_all(const Kernels<T>& k, int lanes, int components) {
    const TriangleMesh mesh = shapes::grid(5, 4);
    const RingTable<T> rings(one_rings_of_faces(20, mesh.faces));
    const Neighborhood<T> hood{rings.rings.offsets.data(), rings.rings.neighbors.data(),
                               rings.inverse_degree.data()};
    const std::size_t rows = static_cast<std::size_t>(20 * 9 * lanes);
    const auto n = static_cast<std::size_t>(components);
    const AlignedVector<T> x = random_values<T>(rows, 1), g = random_values<T>(rows, 2);
    const AlignedVector<T> mp = random_values<T>(81, 3), mn = random_values<T>(81, 4);
    const AlignedVector<T> bias = random_values<T>(9, 5), c = random_values<T>(n * 180, 6);
    const AlignedVector<T> z = random_values<T>(n * static_cast<std::size_t>(lanes), 7);
    const AlignedVector<T> mask = random_values<T>(20, 8);
    AlignedVector<T> lane_weight(static_cast<std::size_t>(lanes), T{1});
    lane_weight.back() = 0;
    std::vector<double> results;
    const auto keep = [&](const AlignedVector<T>& values) {
        results.insert(results.end(), values.begin(), values.end());
    };
    AlignedVector<T> y(rows), dpre(rows), dx(rows), dy(rows), scratch(rows), out(rows);
    AlignedVector<T> small(180), dc(n * 180), codes(z.size()), dmask(20);
    k.conv_forward(hood, x.data(), mp.data(), mn.data(), bias.data(), true, lanes, 0, 20, y.data());
    keep(y);
    k.conv_backward_activation(y.data(), g.data(), true, lanes, 0, 20, dpre.data(), small.data());
    keep(dpre);
    k.conv_backward(hood, x.data(), dpre.data(), mp.data(), mn.data(), lanes, 3, 17, scratch.data(),
                    dx.data(), small.data() + 9, small.data() + 90);
    keep(dx);
    keep(small);
    k.project(c.data(), 180, components, x.data(), lanes, 2, 20, codes.data());
    keep(codes);
    k.expand(c.data(), 180, components, z.data(), lanes, 0, 19, false, out.data());
    k.expand(c.data(), 180, components, z.data(), lanes, 5, 20, true, out.data());
    keep(out);
    k.outer(z.data(), g.data(), 180, components, lanes, 0, 20, dc.data());
    keep(dc);
    results.push_back(k.squared_error(x.data(), g.data(), lane_weight.data(), lanes, 0, 20));
    k.squared_error_backward(x.data(), g.data(), lane_weight.data(), T{0.5}, lanes, 0, 20,
                             dx.data(), dy.data());
    keep(dx);
    keep(dy);
    k.masked_residual(x.data(), g.data(), mask.data(), lanes, 0, 20, out.data());
    keep(out);
    k.masked_residual_backward(x.data(), y.data(), mask.data(), g.data(), lanes, 0, 20, dx.data(),
                               dy.data(), dmask.data());
    keep(dx);
    keep(dmask);
    k.tanh_forward(x.data(), static_cast<std::int64_t>(rows), out.data());
    keep(out);
    AlignedVector<T> p = x, m(rows), v(rows);
    k.adam(p.data(), m.data(), v.data(), g.data(), static_cast<std::int64_t>(rows), T{0.01}, T{0.9},
           T{0.999}, T{0.1}, T{0.001}, T{1e-8});
    keep(p);
    return results;
}

class InstructionSet : public testing::TestWithParam<const char*> {};

template <class T>
void expect_like_generic(const char* name, double tolerance) {
    const Kernels<T>* wide = find_kernels<T>(name);
    if (wide == nullptr) GTEST_SKIP() << "this processor has no " << name;
    for (const int lanes : {8, 16, 48}) {
        for (const int components : {1, 5, 13}) {
            const auto expected = run_all(*find_kernels<T>("generic"), lanes, components);
            const auto got = run_all(*wide, lanes, components);
            ASSERT_EQ(got.size(), expected.size());
            for (std::size_t i = 0; i < got.size(); ++i) {
                EXPECT_TRUE(std::abs(got[i] - expected[i]) <=
                            tolerance * (1 + std::abs(expected[i])))
                    << i << ": " << got[i] << " instead of " << expected[i];
            }
        }
    }
}

TEST_P(InstructionSet, AgreesWithTheGenericOneInDouble) {
    expect_like_generic<double>(GetParam(), 1e-12);
}
// Sums of up to 20 * 9 * 48 terms of size 1: roundoff grows like the square root of their number.
TEST_P(InstructionSet, AgreesWithTheGenericOneInFloat) {
    expect_like_generic<float>(GetParam(), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Wide, InstructionSet, testing::Values("avx2", "avx512"),
                         [](const auto& each) { return std::string(each.param); });

// The float tanh is within 4 units in the last place of the true one, odd, and lets NaN through.
TEST(FloatTanh, IsAccurate) {
    for (const char* name : {"generic", "avx2", "avx512"}) {
        const Kernels<float>* k = find_kernels<float>(name);
        if (k == nullptr) continue;
        AlignedVector<float> x, y;
        for (int i = -40000; i < 40000; ++i) x.push_back(static_cast<float>(i) * 5e-4F);
        for (int i = -90; i < 6; ++i) x.push_back(std::exp2(static_cast<float>(i)));
        x.push_back(std::numeric_limits<float>::infinity());
        x.push_back(-std::numeric_limits<float>::infinity());
        while (x.size() % 8 != 0) x.push_back(0);
        y.resize(x.size());
        k->tanh_forward(x.data(), static_cast<std::int64_t>(x.size()), y.data());
        for (std::size_t i = 0; i < x.size(); ++i) {
            const double truth = std::tanh(static_cast<double>(x[i]));
            EXPECT_TRUE(std::abs(static_cast<double>(y[i]) - truth) <=
                        4 * 6e-8 * std::max(std::abs(truth), 1e-37))
                << name << " at " << x[i] << ": " << y[i];
        }
        AlignedVector<float> nan(8, std::numeric_limits<float>::quiet_NaN());
        k->tanh_forward(nan.data(), 8, nan.data());
        for (const float v : nan) EXPECT_TRUE(std::isnan(v)) << name;
    }
}

// Any number of values, not only whole registers; what lies behind them is left alone.
TEST(FloatTanh, TakesAnyNumberOfValues) {
    for (const char* name : {"generic", "avx2", "avx512"}) {
        const Kernels<float>* k = find_kernels<float>(name);
        if (k == nullptr) continue;
        for (const std::size_t count : {std::size_t{1}, std::size_t{7}, std::size_t{13}}) {
            AlignedVector<float> x(count, 0.5F), y(count + 1, 9.0F);
            k->tanh_forward(x.data(), static_cast<std::int64_t>(count), y.data());
            for (std::size_t i = 0; i < count; ++i) EXPECT_NEAR(y[i], std::tanh(0.5), 1e-7) << name;
            EXPECT_EQ(y[count], 9.0F) << name;
        }
    }
}

}  // namespace
}  // namespace mscomp::nn
