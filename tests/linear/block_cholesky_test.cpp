// SPDX-License-Identifier: MIT
#include "mscomp/linear/block_cholesky.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
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

/// Laplacian of a grid of columns x columns vertices, held at one corner.
Matrix grid_matrix(int columns) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.emplace_back(0, 0, 1.0);
    const auto join = [&](int i, int j) {
        const double weight = 1 + 0.5 * std::sin(i + 2.0 * j);
        entries.emplace_back(i, i, weight);
        entries.emplace_back(j, j, weight);
        entries.emplace_back(i, j, -weight);
        entries.emplace_back(j, i, -weight);
    };
    for (int y = 0; y < columns; ++y) {
        for (int x = 0; x < columns; ++x) {
            if (x + 1 < columns) join(y * columns + x, y * columns + x + 1);
            if (y + 1 < columns) join(y * columns + x, (y + 1) * columns + x);
        }
    }
    Matrix matrix(columns * columns, columns * columns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

template <std::size_t kLanes>
std::vector<Lanes<kLanes>> random_rows(Eigen::Index size) {
    const CounterRandom random(1, 2);
    std::vector<Lanes<kLanes>> rows(static_cast<std::size_t>(size));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        for (std::size_t lane = 0; lane < kLanes; ++lane) {
            rows[i][lane] = random.normal(8 * i + lane);
        }
    }
    return rows;
}

template <std::size_t kLanes>
std::vector<Lanes<kLanes>> solved(const BlockCholesky& factor, std::vector<Lanes<kLanes>> rows) {
    std::vector<Lanes<kLanes>> work;
    factor.solve(rows, work);
    return rows;
}

template <std::size_t kLanes>
Eigen::VectorXd lane_of(const std::vector<Lanes<kLanes>>& rows, std::size_t lane) {
    Eigen::VectorXd column(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        column[static_cast<Eigen::Index>(i)] = rows[i][lane];
    }
    return column;
}

class BlockCholeskyBy : public testing::TestWithParam<Elimination> {};

// A A⁻¹ b = b, in every lane: backward stable, so to rounding of |A| |x|.
template <std::size_t kLanes>
void expect_solves(const Matrix& a, Elimination elimination) {
    const BlockCholesky factor(a, "a matrix", elimination);
    EXPECT_EQ(factor.elimination(), elimination);
    const auto b = random_rows<kLanes>(a.rows()), x = solved(factor, b);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const Eigen::VectorXd solution = lane_of(x, lane);
        const double left = (a * solution - lane_of(b, lane)).norm();
        EXPECT_TRUE(left <= 1e-14 * (8 * solution.norm() + lane_of(b, lane).norm())) << left;
    }
}

TEST_P(BlockCholeskyBy, SolvesForEveryLane) {
    for (const Matrix& a : {ring_matrix(37), grid_matrix(60)}) {
        expect_solves<1>(a, GetParam());
        expect_solves<4>(a, GetParam());
        expect_solves<8>(a, GetParam());
    }
}

TEST_P(BlockCholeskyBy, LanesDoNotSeeEachOther) {
    const BlockCholesky factor(grid_matrix(30), "a grid", GetParam());
    auto rows = random_rows<4>(900);
    const auto one = solved(factor, rows);
    for (auto& row : rows) row[1] = 1e100;
    const auto other = solved(factor, rows);
    for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i][0], other[i][0]);
}

// Any number of lanes gives the same bits.
TEST_P(BlockCholeskyBy, LanesAreBitwiseThoseOfOne) {
    const BlockCholesky factor(grid_matrix(40), "a grid", GetParam());
    const auto eight = random_rows<8>(1600);
    const auto truth = solved(factor, eight);
    for (std::size_t lane = 0; lane < 8; ++lane) {
        std::vector<Lanes<1>> one(eight.size());
        std::vector<Lanes<4>> four(eight.size());
        for (std::size_t i = 0; i < one.size(); ++i) {
            one[i][0] = four[i][lane % 4] = eight[i][lane];
        }
        one = solved(factor, one);
        four = solved(factor, four);
        for (std::size_t i = 0; i < one.size(); ++i) {
            ASSERT_EQ(one[i][0], truth[i][lane]);
            ASSERT_EQ(four[i][lane % 4], truth[i][lane]);
        }
    }
}

// The Laplacian of a ring plus a little is definite, minus it is negative, zero is singular.
TEST_P(BlockCholeskyBy, RefusesWhatIsNotPositiveDefinite) {
    const Matrix negative = -ring_matrix(5);
    EXPECT_THROW(BlockCholesky(negative, "minus a ring", GetParam()), NumericalError);
    Matrix zero(3, 3);
    EXPECT_THROW(BlockCholesky(zero, "nothing", GetParam()), NumericalError);
    Matrix late = grid_matrix(20);
    late.coeffRef(399, 399) = -1;
    EXPECT_THROW(BlockCholesky(late, "a grid with a hole", GetParam()), NumericalError);
    late.coeffRef(399, 399) = std::nan("");
    EXPECT_THROW(BlockCholesky(late, "a grid with nothing", GetParam()), NumericalError);
}

TEST_P(BlockCholeskyBy, LooksAtTheLowerTriangleOnly) {
    const Matrix a = grid_matrix(12);
    const Matrix lower = a.triangularView<Eigen::Lower>();
    const auto rows = random_rows<4>(a.rows());
    EXPECT_EQ(solved(BlockCholesky(a, "a grid", GetParam()), rows),
              solved(BlockCholesky(lower, "half a grid", GetParam()), rows));
}

template <std::size_t kLanes>
std::vector<Lanes<kLanes>> half(const BlockCholesky& factor, std::vector<Lanes<kLanes>> rows) {
    std::vector<Lanes<kLanes>> work;
    factor.solve_half(rows, work);
    return rows;
}

template <std::size_t kLanes>
std::vector<Lanes<kLanes>> transposed_half(const BlockCholesky& factor,
                                           std::vector<Lanes<kLanes>> rows) {
    std::vector<Lanes<kLanes>> work;
    factor.solve_transposed_half(rows, work);
    return rows;
}

template <std::size_t kLanes>
void expect_halves(const Matrix& a, Elimination elimination) {
    const BlockCholesky factor(a, "a matrix", elimination);
    const auto b = random_rows<kLanes>(a.rows());
    const auto y = half(factor, b), x = transposed_half(factor, y), whole = solved(factor, b);
    const auto z = transposed_half(factor, b);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const Eigen::VectorXd right = lane_of(b, lane), truth = lane_of(whole, lane);
        EXPECT_TRUE((lane_of(x, lane) - truth).norm() <= 1e-13 * truth.norm());
        const double square = right.dot(truth);
        EXPECT_TRUE(std::abs(lane_of(y, lane).squaredNorm() - square) <= 1e-12 * square);
        const Eigen::VectorXd image = lane_of(z, lane);
        EXPECT_TRUE(std::abs(image.dot(a * image) - right.squaredNorm()) <=
                    1e-12 * right.squaredNorm());
    }
}

// A = C Cᵀ: C⁻ᵀ C⁻¹ b = A⁻¹ b, |C⁻¹ b|² = bᵀ A⁻¹ b, and (C⁻ᵀ y)ᵀ A (C⁻ᵀ y) = |y|².
TEST_P(BlockCholeskyBy, HalvesMakeTheMatrixTheIdentity) {
    for (const Matrix& a : {ring_matrix(37), grid_matrix(40)}) {
        expect_halves<1>(a, GetParam());
        expect_halves<4>(a, GetParam());
        expect_halves<8>(a, GetParam());
    }
}

TEST_P(BlockCholeskyBy, HalvesAreTheSameBitsForAnyNumberOfLanes) {
    const BlockCholesky factor(grid_matrix(30), "a grid", GetParam());
    const auto eight = random_rows<8>(900);
    const auto halves = half(factor, eight), others = transposed_half(factor, eight);
    for (std::size_t lane = 0; lane < 8; ++lane) {
        std::vector<Lanes<1>> one(eight.size());
        std::vector<Lanes<4>> four(eight.size());
        for (std::size_t i = 0; i < one.size(); ++i) {
            one[i][0] = four[i][lane % 4] = eight[i][lane];
        }
        const auto half_of_one = half(factor, one);
        const auto other_of_four = transposed_half(factor, four);
        for (std::size_t i = 0; i < one.size(); ++i) {
            ASSERT_EQ(half_of_one[i][0], halves[i][lane]);
            ASSERT_EQ(other_of_four[i][lane % 4], others[i][lane]);
        }
    }
}

INSTANTIATE_TEST_SUITE_P(, BlockCholeskyBy,
                         testing::Values(Elimination::minimum_degree,
                                         Elimination::nested_dissection),
                         [](const auto& test) {
                             return test.param == Elimination::minimum_degree ? "MinimumDegree"
                                                                              : "NestedDissection";
                         });

// The solution does not depend on the order of elimination.
TEST(BlockCholesky, OrdersAgree) {
    const Matrix a = grid_matrix(150);
    const auto b = random_rows<8>(a.rows());
    const auto one = solved(BlockCholesky(a, "a grid", Elimination::minimum_degree), b);
    const auto other = solved(BlockCholesky(a, "a grid", Elimination::nested_dissection), b);
    for (std::size_t lane = 0; lane < 8; ++lane) {
        const Eigen::VectorXd x = lane_of(one, lane);
        EXPECT_TRUE((x - lane_of(other, lane)).norm() <= 1e-9 * x.norm());
    }
}

// Another matrix in the order found for the first: still its own solution.
TEST(BlockCholesky, TakesOverTheOrderOfAnother) {
    for (const Elimination elimination :
         {Elimination::minimum_degree, Elimination::nested_dissection}) {
        const BlockCholesky first(grid_matrix(50), "a grid", elimination);
        Matrix a = grid_matrix(50);
        for (int i = 0; i < a.rows(); ++i) a.coeffRef(i, i) += 3;
        const BlockCholesky second(a, "a heavier grid", first);
        EXPECT_EQ(second.elimination(), elimination);
        EXPECT_EQ(second.stored_numbers(), first.stored_numbers());
        const auto b = random_rows<4>(a.rows()), x = solved(second, b);
        for (std::size_t lane = 0; lane < 4; ++lane) {
            EXPECT_TRUE((a * lane_of(x, lane) - lane_of(b, lane)).norm() <= 1e-11);
        }
    }
}

// The order of a ring does not suit a grid: the factor shows whose order it was.
TEST(BlockCholesky, TakesOverTheOrderWhereItIsNotItsOwn) {
    const Matrix grid = grid_matrix(50);
    const BlockCholesky ring(ring_matrix(2500), "a ring", Elimination::nested_dissection);
    const BlockCholesky own(grid, "a grid", Elimination::nested_dissection);
    EXPECT_GT(BlockCholesky(grid, "a grid", ring).stored_numbers(), own.stored_numbers());
}

// Small systems by minimum degree, large ones by nested dissection; both solve.
TEST(BlockCholesky, PicksTheOrderBySize) {
    EXPECT_EQ(BlockCholesky(grid_matrix(20), "a grid").elimination(), Elimination::minimum_degree);
    const Matrix a = ring_matrix(static_cast<int>(kLargeSystem));
    const BlockCholesky large(a, "a large ring");
    EXPECT_EQ(large.elimination(), Elimination::nested_dissection);
    const auto b = random_rows<4>(a.rows()), x = solved(large, b);
    EXPECT_TRUE((a * lane_of(x, 2) - lane_of(b, 2)).norm() <= 1e-12 * lane_of(b, 2).norm());
}

// The same bits every time: METIS draws random numbers.
TEST(BlockCholesky, IsTheSameEveryTime) {
    const Matrix a = grid_matrix(80);
    const auto b = random_rows<4>(a.rows());
    const auto truth = solved(BlockCholesky(a, "a grid", Elimination::nested_dissection), b);
    std::vector<std::vector<Lanes<4>>> again(6);
    parallel_for(6, [&](std::int64_t k) {
        again[static_cast<std::size_t>(k)] =
            solved(BlockCholesky(a, "a grid", Elimination::nested_dissection), b);
    });
    for (const auto& rows : again) EXPECT_EQ(rows, truth);
}

}  // namespace
}  // namespace mscomp
