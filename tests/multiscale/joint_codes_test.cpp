// SPDX-License-Identifier: MIT
#include "multiscale/joint_codes.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "ball_cases.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

TEST(BallComponents, GiveBackWhatTheyWereGiven) {
    cases::Sphere sphere;
    BallComponents components = sphere.components(7, 0.3);
    for (int k = 0; k < 7; ++k) {
        const std::vector<float> values = components.component(k);
        double square = 0;
        for (const float x : values) square += static_cast<double>(x) * static_cast<double>(x);
        EXPECT_NEAR(square, 1, 1e-6);
        EXPECT_EQ(values.size(), 9 * components.balls()[at(k)].vertices.size());
    }
    std::vector<float> other(components.component(3).size(), 2.0F);
    components.set_component(3, other);
    EXPECT_EQ(components.component(3), other);
    for (int v = 0; v < sphere.vertices(); ++v) {
        const auto acting = components.at_vertex(v);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            const auto& ball = components.balls()[at(acting[a])].vertices;
            EXPECT_TRUE(std::ranges::binary_search(ball, v));
            if (acting[a] == 3) {
                EXPECT_EQ(components.values(v)[9 * a], 2.0F);
            }
        }
    }
}

// Against dense algebra, in features and in positions.
class JointCodesOf : public testing::TestWithParam<int> {};

TEST_P(JointCodesOf, AreTheLeastSquaresOfAllComponentsAtOnce) {
    cases::Sphere sphere;
    const BallComponents components = sphere.components(20, 0.35, 17, GetParam());
    const MatrixXd C = cases::dense(components);
    const MatrixXd shapes = cases::random_matrix(C.rows(), 5, 1);
    const MetricRows rows = cases::rows_of(shapes, GetParam());
    const MatrixXd rounded = shapes.cast<float>().cast<double>();
    const MatrixXd gram = C.transpose() * C;
    EXPECT_LT((gram_matrix(components) - gram).norm(), 1e-12);
    EXPECT_LT((products(components, rows) - C.transpose() * rounded).norm(), 1e-10);
    const MatrixXd wanted = (gram + 1e-7 * gram.trace() / 20 * MatrixXd::Identity(20, 20))
                                .fullPivLu()
                                .solve(C.transpose() * rounded);
    const MatrixXd codes = JointCodes(components).solve(products(components, rows));
    EXPECT_LT((codes - wanted).norm(), 1e-9 * wanted.norm());
    const Eigen::VectorXf one = shapes.col(2).cast<float>();
    const Eigen::VectorXd product = products(components, std::span(one.data(), at(one.size())));
    EXPECT_LT((product - C.transpose() * rounded.col(2)).norm(), 1e-10);
}
INSTANTIATE_TEST_SUITE_P(Widths, JointCodesOf, testing::Values(9, 3));

// What components make has their codes; a component that is zero has the code 0.
TEST(JointCodes, OfASumAreItsCodes) {
    cases::Sphere sphere;
    BallComponents components = sphere.components(12, 0.3);
    components.set_component(4, std::vector<float>(components.component(4).size(), 0.0F));
    MatrixXd codes = cases::random_matrix(12, 3, 2);
    codes.row(4).setZero();
    const MetricRows rows = cases::rows_of(cases::dense(components) * codes);
    const MatrixXd found = JointCodes(components).solve(products(components, rows));
    EXPECT_LT((found - codes).norm(), 1e-4);
    EXPECT_EQ(found.row(4).norm(), 0);
}

TEST(JointCodes, OverlapIsTheSumOfProductsOfSquares) {
    cases::Sphere sphere;
    const BallComponents components = sphere.components(6, 0.3);
    const MatrixXd C = cases::dense(components);
    const MatrixXd found = overlaps(components);
    for (int k = 0; k < 6; ++k) {
        for (int l = 0; l < 6; ++l) {
            double sum = 0;
            for (int v = 0; v < sphere.vertices(); ++v) {
                sum += C.col(k).segment<9>(9 * v).squaredNorm() *
                       C.col(l).segment<9>(9 * v).squaredNorm();
            }
            EXPECT_NEAR(found(k, l), sum, 1e-12);
        }
    }
}

TEST(JointCodes, ThreadsDoNotChangeABit) {
    cases::Sphere sphere;
    const BallComponents components = sphere.components(20, 0.35);
    const MetricRows rows = cases::rows_of(cases::random_matrix(9 * sphere.vertices(), 5, 1));
    set_thread_count(1);
    const MatrixXd wanted = products(components, rows), gram = gram_matrix(components);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_TRUE(products(components, rows) == wanted);
        EXPECT_TRUE(gram_matrix(components) == gram);
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace mscomp
