// SPDX-License-Identifier: MIT
#include "model/refit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "dense.h"
#include "linear_model.h"

namespace mscomp {
namespace {

using cases::least_squares;
using cases::normal_numbers;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Changes (rows,K), a column each, that overlap, and codes (N,K).
struct RefitCase {
    MatrixXd changes, codes;

    Refit refit() const { return {changes.transpose() * changes, codes}; }
    MatrixXd shapes() const { return changes * codes.transpose(); }
    /// What components with these columns leave of the shapes at best, as a share of their squares.
    double lost(const MatrixXd& columns) const {
        if (columns.cols() == 0) return 1;
        return cases::unexplained(columns, shapes()).squaredNorm() / shapes().squaredNorm();
    }
    MatrixXd columns(const std::vector<int>& which) const {
        MatrixXd result(changes.rows(), static_cast<Index>(which.size()));
        for (std::size_t i = 0; i < which.size(); ++i) {
            result.col(static_cast<Index>(i)) = changes.col(which[i]);
        }
        return result;
    }
    /// The columns of what is left, merged ones together.
    MatrixXd columns(const Refit& refit) const {
        const std::vector<int> left = refit.left();
        MatrixXd result(changes.rows(), static_cast<Index>(left.size()));
        for (std::size_t i = 0; i < left.size(); ++i) {
            result.col(static_cast<Index>(i)) = changes * refit.direction(left[i]);
        }
        return result;
    }
};

RefitCase overlapping(int components = 8, int shapes = 12) {
    RefitCase result{normal_numbers(27, components, 1), normal_numbers(shapes, components, 2)};
    for (Index k = 1; k < components; ++k) result.changes.col(k) += 0.8 * result.changes.col(k - 1);
    for (Index k = 0; k < components; ++k) result.codes.col(k) *= std::pow(0.6, k);
    return result;
}

std::vector<int> all_but(int count, int left_out) {
    std::vector<int> result;
    for (int k = 0; k < count; ++k) {
        if (k != left_out) result.push_back(k);
    }
    return result;
}

// Σ z_k² / (G⁻¹)_kk is what least squares over the other components leave of the shapes.
TEST(Refit, CostIsWhatRefittingByBruteForceLoses) {
    const RefitCase shapes = overlapping();
    const Refit refit = shapes.refit();
    for (int k = 0; k < 8; ++k) {
        EXPECT_NEAR(refit.cost(k), shapes.lost(shapes.columns(all_but(8, k))), 1e-8) << k;
    }
}

// The same after some are gone, of what all of them gave, and of all that is lost.
TEST(Refit, CostsAddUpToWhatAllThatIsGoneLoses) {
    const RefitCase shapes = overlapping();
    Refit refit = shapes.refit();
    refit.drop_all({2, 5, 0});
    EXPECT_EQ(refit.left(), (std::vector<int>{1, 3, 4, 6, 7}));
    EXPECT_NEAR(refit.lost(), shapes.lost(shapes.columns(refit.left())), 1e-8);
    EXPECT_NEAR(refit.lost() + refit.cost(3), shapes.lost(shapes.columns({1, 4, 6, 7})), 1e-8);
}

// Refitted codes are those of least squares, a linear function of all codes.
TEST(Refit, ReadingIsLeastSquares) {
    const RefitCase shapes = overlapping();
    Refit refit = shapes.refit();
    refit.drop_all({2, 5, 0});
    const std::vector<int> left = refit.left();
    const MatrixXd fitted = least_squares(shapes.columns(left), shapes.shapes());
    for (std::size_t i = 0; i < left.size(); ++i) {
        const VectorXd codes = shapes.codes * refit.reading(left[i]);
        EXPECT_LT((codes - fitted.row(static_cast<Index>(i)).transpose()).norm(),
                  1e-6 * fitted.norm());
    }
}

// Each goes where it costs least, never more than the share in all; what stays costs too much.
TEST(Refit, TakesTheCheapestAsLongAsAllStaysWithinTheShare) {
    const RefitCase shapes = overlapping();
    for (const double share : {0.0, 1e-4, 1e-3, 1e-2, 0.1, 0.5}) {
        Refit refit = shapes.refit();
        refit.reduce(share, 1);
        EXPECT_LE(refit.lost(), share);
        EXPECT_NEAR(refit.lost(), shapes.lost(shapes.columns(refit.left())), 1e-8);
        for (const int k : refit.left()) EXPECT_GT(refit.lost() + refit.cost(k), share);
        std::vector<int> there{0, 1, 2, 3, 4, 5, 6, 7};
        for (const RefitStep& step : refit.steps()) {
            double least = 1;
            for (const int k : there) {
                std::vector<int> without = there;
                std::erase(without, k);
                least = std::min(least, shapes.lost(shapes.columns(without)) -
                                            shapes.lost(shapes.columns(there)));
            }
            EXPECT_NEAR(step.cost, least, 1e-8);
            std::erase(there, step.component);
        }
    }
}

// Ten that cost a tenth each: two are within a quarter, though each is.
TEST(Refit, ShareIsOfAllThatGoTogether) {
    RefitCase shapes{MatrixXd::Identity(27, 10), MatrixXd::Identity(10, 10)};
    Refit refit = shapes.refit();
    refit.reduce(0.25, 2);
    EXPECT_EQ(refit.left().size(), 8U);
    EXPECT_NEAR(refit.lost(), 0.2, 1e-8);
}

TEST(Refit, NothingGoesWhereEachIsNeeded) {
    RefitCase shapes{MatrixXd::Identity(27, 6), normal_numbers(20, 6, 3)};
    Refit refit = shapes.refit();
    refit.reduce(0.01, 0.95);
    EXPECT_EQ(refit.left().size(), 6U);
    EXPECT_TRUE(refit.steps().empty());
    EXPECT_EQ(refit.lost(), 0);
}

// Whatever the share.
TEST(Refit, WhatNoShapeUsesAndWhatChangesNothingGoFirst) {
    RefitCase shapes = overlapping();
    shapes.codes.col(1).setZero();
    shapes.changes.col(4).setZero();
    Refit refit = shapes.refit();
    refit.reduce(0, 1);
    ASSERT_EQ(refit.steps().size(), 2U);
    EXPECT_EQ(refit.steps()[0].component, 1);
    EXPECT_EQ(refit.steps()[1].component, 4);
    EXPECT_EQ(refit.lost(), 0);
}

// A component and its double, of another size and with codes of its own, are one; the weaker one is
// merged into the other, which from then on moves as both did.
TEST(Refit, ADoubleIsMergedAndNothingIsLost) {
    RefitCase shapes = overlapping();
    shapes.changes.col(6) = -3 * shapes.changes.col(1);
    Refit refit = shapes.refit();
    refit.reduce(1e-7, 0.95);
    ASSERT_EQ(refit.steps().size(), 1U);
    EXPECT_EQ(refit.steps()[0].component, 6);
    EXPECT_EQ(refit.steps()[0].into, 1);
    EXPECT_NEAR(refit.steps()[0].likeness.changes, 1, 1e-9);
    EXPECT_LT(refit.lost(), 1e-7);
    EXPECT_LT(shapes.lost(shapes.columns(refit)), 1e-9);
}

// Codes that go together: one component that moves both, as far as the codes go.
TEST(Refit, CodesThatPredictEachOtherAreMergedAlongTheirDirection) {
    RefitCase shapes{MatrixXd::Identity(27, 5), normal_numbers(30, 5, 4)};
    shapes.codes.col(3) = -0.5 * shapes.codes.col(0);
    Refit refit = shapes.refit();
    refit.reduce(1e-7, 0.95);
    ASSERT_EQ(refit.steps().size(), 1U);
    EXPECT_EQ(refit.steps()[0].component, 3);
    EXPECT_EQ(refit.steps()[0].into, 0);
    const VectorXd direction = refit.direction(0);
    EXPECT_NEAR(direction[0], 1, 1e-12);
    EXPECT_NEAR(direction[3], -0.5, 1e-7);
    EXPECT_LT(shapes.lost(shapes.columns(refit)), 1e-9);
    const VectorXd codes = shapes.codes * refit.reading(0);
    EXPECT_LT((codes - shapes.codes.col(0)).norm(), 1e-6 * codes.norm());
}

// Of all directions in which two components may move together none loses less, the others refitted;
// and what it costs is that.
TEST(Refit, NoDirectionOfAMergedPairLosesLess) {
    RefitCase shapes{normal_numbers(27, 5, 5), normal_numbers(40, 5, 6)};
    shapes.codes.col(3) = 0.7 * shapes.codes.col(0) + 0.02 * shapes.codes.col(3);
    Refit refit = shapes.refit();
    refit.reduce(1e-2, 0.9);
    ASSERT_EQ(refit.steps().front().component, 3);
    ASSERT_EQ(refit.steps().front().into, 0);
    EXPECT_NEAR(refit.lost(), shapes.lost(shapes.columns(refit)), 1e-8);
    MatrixXd columns = shapes.columns({1, 2, 4, 0});
    for (const double angle : {0.3, 0.5, 0.55, 0.59, 0.6, 0.61, 0.62, 0.65, 0.7, 1.0}) {
        columns.col(3) =
            std::cos(angle) * shapes.changes.col(0) + std::sin(angle) * shapes.changes.col(3);
        EXPECT_GE(shapes.lost(columns), refit.steps().front().cost - 1e-9) << angle;
    }
}

// Three alike become one, which stands for all of them.
TEST(Refit, MoreThanTwoAreMerged) {
    RefitCase shapes{MatrixXd::Identity(27, 5), normal_numbers(30, 5, 7)};
    shapes.codes.col(3) = 0.5 * shapes.codes.col(0);
    shapes.codes.col(4) = 0.25 * shapes.codes.col(0);
    Refit refit = shapes.refit();
    refit.reduce(1e-7, 0.95);
    EXPECT_EQ(refit.left(), (std::vector<int>{0, 1, 2}));
    for (const RefitStep& step : refit.steps()) EXPECT_EQ(step.into, 0);
    EXPECT_NEAR(refit.direction(0)[3], 0.5, 1e-6);
    EXPECT_NEAR(refit.direction(0)[4], 0.25, 1e-6);
    EXPECT_LT(shapes.lost(shapes.columns(refit)), 1e-9);
}

// Below what is asked for they stay two; merging costs, and no more than is allowed is lost.
TEST(Refit, NothingIsMergedBelowTheLikenessOrBeyondTheShare) {
    RefitCase shapes{MatrixXd::Identity(27, 4), normal_numbers(400, 4, 8)};
    shapes.codes.col(3) = shapes.codes.col(0) + 0.2 * shapes.codes.col(3);  // 0.98
    const auto steps = [&](double share, double alike) {
        Refit refit = shapes.refit();
        refit.reduce(share, alike);
        return refit.steps().size();
    };
    EXPECT_EQ(steps(0.05, 0.95), 1U);
    EXPECT_EQ(steps(0.05, 0.99), 0U);
    EXPECT_EQ(steps(1e-3, 0.95), 0U);
}

// One shape says nothing of another: where a single one makes two codes alike they are not, and
// four shapes do not show that two codes go together.
TEST(Refit, CodesAreAlikeOnlyWhereShapesLeftOutSaySo) {
    RefitCase single{MatrixXd::Identity(27, 3), 0.01 * normal_numbers(40, 3, 9)};
    single.codes.row(7).head<2>().setConstant(10);
    Refit refit = single.refit();
    refit.reduce(1e-4, 0.95);
    for (const RefitStep& step : refit.steps()) EXPECT_EQ(step.into, -1);
    RefitCase few{MatrixXd::Identity(27, 3), normal_numbers(4, 3, 10)};
    few.codes.col(1) = few.codes.col(0) + 0.15 * few.codes.col(1);
    Refit unsure = few.refit();
    unsure.reduce(0.05, 0.95);
    for (const RefitStep& step : unsure.steps()) EXPECT_EQ(step.into, -1);
}

// Whatever order they stand in.
TEST(Refit, OrderDoesNotMatter) {
    RefitCase shapes = overlapping(10, 30);
    shapes.codes.col(7) = 0.6 * shapes.codes.col(2);
    Refit first = shapes.refit();
    first.reduce(1e-2, 0.95);
    const std::vector<int> order{3, 9, 0, 7, 1, 8, 2, 5, 4, 6};
    Refit second = RefitCase{shapes.columns(order), shapes.codes(Eigen::all, order)}.refit();
    second.reduce(1e-2, 0.95);
    ASSERT_EQ(first.steps().size(), second.steps().size());
    ASSERT_GT(first.steps().size(), 2U);
    EXPECT_TRUE(std::ranges::any_of(first.steps(), [](const auto& s) { return s.into >= 0; }));
    for (std::size_t i = 0; i < first.steps().size(); ++i) {
        const RefitStep &a = first.steps()[i], &b = second.steps()[i];
        EXPECT_EQ(a.component, order[at(b.component)]);
        EXPECT_EQ(a.into, b.into < 0 ? -1 : order[at(b.into)]);
        EXPECT_NEAR(a.cost, b.cost, 1e-10);
    }
}

// Ten of the same, more than shapes, and a unit of 1e±6.
TEST(Refit, ManyDoublesAndAnyUnit) {
    for (const double unit : {1e-6, 1.0, 1e6}) {
        RefitCase shapes{unit * normal_numbers(27, 12, 11), normal_numbers(5, 12, 12)};
        for (Index k = 3; k < 12; ++k) shapes.changes.col(k) = shapes.changes.col(2);
        Refit refit = shapes.refit();
        refit.reduce(1e-6, 2);
        EXPECT_EQ(refit.left().size(), 3U) << unit;
        EXPECT_LT(shapes.lost(shapes.columns(refit)), 1e-6);
    }
}

}  // namespace
}  // namespace mscomp
