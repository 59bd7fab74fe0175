// SPDX-License-Identifier: MIT
#include "multiscale/space_error.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ball_cases.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

/// Components that can say every feature of a few vertices, and shapes beside what they make of
/// codes. Rotations of the shapes reach beyond π at some vertices.
class SpaceErrorTest : public testing::Test {
  protected:
    SpaceErrorTest() {
        codes_ = 3 * cases::random_matrix(components_.count(), kShapes, 5);
        shapes_ = cases::dense(components_) * codes_;
        for (int v = 0; v < sphere_.vertices(); ++v) {
            // A turn by nearly π about z, as mapped: the same everywhere, 0 where v is odd.
            shapes_(9 * v + 2, 1) += v % 2 == 0 ? 2 * 3.1 * root(v) : 0;
        }
    }
    double root(int v) const { return sphere_.scale.root(at(v)); }
    SpaceError error(const MatrixXd& targets) const {
        return {sphere_.mesh, "cotangent", sphere_.scale, cases::rows_of(targets)};
    }
    std::vector<double> value(const SpaceError& of, const MatrixXd& codes) {
        return of.evaluate(components_, codes, &gradient_);
    }

    static constexpr int kShapes = 3;
    cases::Sphere sphere_;
    BallComponents components_ = sphere_.components(10, 0.3);
    MatrixXd codes_, shapes_;
    MetricRows gradient_{sphere_.vertices(), kShapes};
};

// Against central differences along every code, and along components: by the chain rule these are
// inner products of the gradient.
TEST_F(SpaceErrorTest, GradientIsThatOfDifferences) {
    const SpaceError of = error(shapes_);
    MatrixXd z = codes_ + 0.3 * cases::random_matrix(codes_.rows(), kShapes, 6);
    value(of, z);
    const MetricRows gradient = gradient_;
    const MatrixXd C = cases::dense(components_);
    constexpr double kStep = 1e-4;
    for (int m = 0; m < kShapes; ++m) {
        Eigen::VectorXd by_row(C.rows());
        for (Eigen::Index i = 0; i < C.rows(); ++i) by_row[i] = gradient.value(at(i), m);
        const Eigen::VectorXd by_code = C.transpose() * by_row;
        for (Eigen::Index k = 0; k < z.rows(); ++k) {
            MatrixXd up = z, down = z;
            up(k, m) += kStep;
            down(k, m) -= kStep;
            const double slope = (value(of, up)[at(m)] - value(of, down)[at(m)]) / (2 * kStep);
            EXPECT_NEAR(by_code[k], slope, 2e-4 * by_code.norm() + 1e-6) << m << ", " << k;
        }
    }
}

TEST_F(SpaceErrorTest, IsZeroAtTheShapesThemselves) {
    const SpaceError of = error(cases::dense(components_) * codes_);
    for (const double e : value(of, codes_)) EXPECT_LT(e, 1e-3);
    MatrixXd away = codes_;
    away.array() += 0.5;
    for (const double e : value(of, away)) EXPECT_GT(e, 1);
}

// A constant turn of all features turns the positions, which costs nothing.
TEST_F(SpaceErrorTest, RigidMotionsCostNothing) {
    MatrixXd turned = MatrixXd::Zero(shapes_.rows(), kShapes);
    for (int v = 0; v < sphere_.vertices(); ++v) {
        for (int m = 0; m < kShapes; ++m) turned(9 * v + m, m) = 2 * 0.8 * root(v);
    }
    const SpaceError of = error(turned);
    for (const double e : value(of, MatrixXd::Zero(codes_.rows(), kShapes))) EXPECT_LT(e, 1e-4);
}

// Near a shape that can be reached E is quadratic: twice the normal matrix is its Hessian.
TEST_F(SpaceErrorTest, NormalMatrixIsHalfTheHessian) {
    const MatrixXd z = 0.1 * codes_;
    const SpaceError of = error(cases::dense(components_) * z);
    const LosslessReconstruction lossless(sphere_.mesh, EdgeWeights::cotangent);
    const MatrixXd h = of.normal_matrices(components_, z, lossless).front();
    constexpr double kStep = 1e-2;
    for (Eigen::Index k = 0; k < 5; ++k) {
        MatrixXd up = z, down = z;
        up(k, 0) += kStep;
        down(k, 0) -= kStep;
        const double second = (value(of, up)[0] + value(of, down)[0]) / (kStep * kStep);
        EXPECT_NEAR(2 * h(k, k), second, 0.01 * second) << k;
    }
    EXPECT_LT((h - h.transpose()).norm(), 1e-9 * h.norm());
}

TEST_F(SpaceErrorTest, ThreadsDoNotChangeABit) {
    const SpaceError of = error(shapes_);
    set_thread_count(1);
    const std::vector<double> wanted = value(of, codes_);
    const std::vector<float> gradient(gradient_.all().begin(), gradient_.all().end());
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(value(of, codes_), wanted);
        EXPECT_TRUE(std::ranges::equal(gradient_.all(), gradient));
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace mscomp
