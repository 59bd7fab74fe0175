// SPDX-License-Identifier: MIT
#include "mscomp/linear/block_cholesky.h"

#include <gtest/gtest.h>

#include "mscomp/base/error.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// Laplacian of a ring of `size` vertices plus a little of the identity: definite.
Matrix ring_matrix(int size) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < size; ++i) {
        entries.emplace_back(i, i, 2.125 + 0.01 * i);
        entries.emplace_back(i, (i + 1) % size, -1.0);
        entries.emplace_back((i + 1) % size, i, -1.0);
    }
    Matrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

// A A⁻¹ b = b, in every lane.
template <std::size_t kLanes>
void expect_solves() {
    const int size = 37;
    const Matrix a = ring_matrix(size);
    const BlockCholesky factor(a, "a ring");
    const CounterRandom random(1, 2);
    std::vector<Lanes<kLanes>> b(size), x, work;
    std::uint64_t draw = 0;
    for (auto& row : b) {
        for (double& value : row) value = random.normal(draw++);
    }
    x = b;
    factor.solve(x, work);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        Eigen::VectorXd solution(size);
        for (int i = 0; i < size; ++i) solution[i] = x[static_cast<std::size_t>(i)][lane];
        const Eigen::VectorXd back = a * solution;
        for (int i = 0; i < size; ++i) {
            EXPECT_NEAR(back[i], b[static_cast<std::size_t>(i)][lane], 1e-12);
        }
    }
}

TEST(BlockCholesky, SolvesForEveryLane) {
    expect_solves<4>();
    expect_solves<8>();
}

TEST(BlockCholesky, LanesDoNotSeeEachOther) {
    const BlockCholesky factor(ring_matrix(11), "a ring");
    std::vector<Lanes<4>> one(11, {1, 0, 0, 0}), other(11, {1, 5, -7, 1e100}), work;
    factor.solve(one, work);
    factor.solve(other, work);
    for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i][0], other[i][0]);
}

// The Laplacian alone has the constants as its kernel; minus it is negative.
TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
    Matrix negative = -ring_matrix(5);
    EXPECT_THROW(BlockCholesky(negative, "minus a ring"), NumericalError);
    Matrix zero(3, 3);
    EXPECT_THROW(BlockCholesky(zero, "nothing"), NumericalError);
}

}  // namespace
}  // namespace mscomp
