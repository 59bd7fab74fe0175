// SPDX-License-Identifier: MIT
#include "learning/deflation_residual.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "mscomp/base/random.h"

namespace mscomp::nn {
namespace {

using Vector = std::vector<double>;

double dot(const Vector& a, const Vector& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Two random vectors of unit length at right angles.
std::pair<Vector, Vector> orthonormal(std::size_t size, std::uint64_t seed) {
    const CounterRandom random(seed, 0);
    Vector a(size), b(size);
    for (std::size_t i = 0; i < size; ++i) {
        a[i] = random.normal(2 * i);
        b[i] = random.normal(2 * i + 1);
    }
    const double length = std::sqrt(dot(a, a));
    for (double& x : a) x /= length;
    const double along = dot(a, b);
    for (std::size_t i = 0; i < size; ++i) b[i] -= along * a[i];
    const double rest = std::sqrt(dot(b, b));
    for (double& x : b) x /= rest;
    return {a, b};
}

// The singular vectors of a matrix with singular values 0.5 and 0.1 come one after the other, each
// explaining the square of its value; with few shapes and with many, which are added up
// differently.
TEST(DeflationResidual, FindsSingularVectors) {
    constexpr int kManyVertices = 700;
    for (const std::size_t shapes : {8U, 60U}) {
        const auto [u, w] = orthonormal(kManyVertices * 9, 1);
        const auto [p, q] = orthonormal(shapes, 2);
        Vector rows(u.size() * shapes);
        for (std::size_t i = 0; i < u.size(); ++i) {
            for (std::size_t m = 0; m < shapes; ++m) {
                rows[i * shapes + m] = std::atanh(0.5 * u[i] * p[m] + 0.1 * w[i] * q[m]);
            }
        }
        DeflationResidual residual(kManyVertices, static_cast<std::int64_t>(shapes));
        residual.fill(rows.data(), static_cast<std::int64_t>(shapes), 0,
                      static_cast<std::int64_t>(shapes), [](double x) { return std::tanh(x); });
        residual.drop_silent_vertices();
        ASSERT_EQ(residual.vertices().size(), std::size_t{kManyVertices});
        std::vector<int> places(kManyVertices);
        std::iota(places.begin(), places.end(), 0);
        EXPECT_NEAR(residual.energy(), 0.26, 1e-12);

        const DeflationDirection first =
            residual.main_direction(residual.strongest_vertex(), places);
        EXPECT_NEAR(std::abs(dot(first.values, u)), 1, 1e-12) << shapes << " shapes";
        EXPECT_NEAR(std::abs(dot(first.codes, p)), 0.5, 1e-12);
        EXPECT_NEAR(first.explained(), 0.25, 1e-12);
        residual.subtract(first);
        EXPECT_NEAR(residual.energy(), 0.01, 1e-12);

        const DeflationDirection second =
            residual.main_direction(residual.strongest_vertex(), places);
        EXPECT_NEAR(std::abs(dot(second.values, w)), 1, 1e-10) << shapes << " shapes";
        EXPECT_NEAR(second.explained(), 0.01, 1e-12);
    }
}

}  // namespace
}  // namespace mscomp::nn
