// SPDX-License-Identifier: MIT
// Turns of components by what they carry.
#include "units/turn_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int kFitComponents = 3, kFitShapes = 12;

/// Random turns of three components, everywhere, and shapes that add them by random codes.
class TurnFitTest : public testing::Test {
  protected:
    TurnFitTest()
        : field_(shapes::icosphere(1)),
          codes_(kFitShapes, kFitComponents),
          truth_(field_.edge_count(), balls(1), 3),
          turns_(field_.edge_count(), kFitShapes, 3) {
        const CounterRandom random(1, 0);
        for (Eigen::Index i = 0; i < codes_.size(); ++i) {
            codes_(i) = random.normal(static_cast<std::uint64_t>(i));
        }
        const CounterRandom values(1, 1);
        std::uint64_t next = 0;
        for (float& x : truth_.all_values()) x = static_cast<float>(values.normal(next++));
        for (int m = 0; m < kFitShapes; ++m) {
            const Eigen::VectorXf own = codes_.row(m).transpose().cast<float>();
            turns_.set(m, sum(truth_, own));
        }
    }
    /// Of every `step`-th edge.
    std::vector<Ball> balls(int step) const {
        std::vector<int> edges;
        for (int e = 0; e < field_.edge_count(); e += step) edges.push_back(e);
        return std::vector<Ball>(kFitComponents, Ball{0, edges});
    }
    static std::vector<float> sum(const BallComponents& components, const Eigen::VectorXf& codes) {
        std::vector<float> row(3 * at(components.vertex_count()), 0.0F);
        for (int k = 0; k < components.count(); ++k) {
            const std::vector<float> values = components.component(k);
            const std::vector<int>& edges = components.balls()[at(k)].vertices;
            for (std::size_t i = 0; i < values.size(); ++i) {
                row[3 * at(edges[i / 3]) + i % 3] += codes[k] * values[i];
            }
        }
        return row;
    }
    /// What the components leave of what all shapes carry.
    double left(const BallComponents& components) const {
        double squares = 0;
        for (int m = 0; m < kFitShapes; ++m) {
            const Eigen::VectorXf own = codes_.row(m).transpose().cast<float>();
            const std::vector<float> said = sum(components, own), whole = turns_.row(m);
            std::vector<Vector3d> turns(at(field_.edge_count()));
            for (std::size_t i = 0; i < said.size(); ++i) {
                turns[i / 3][static_cast<Eigen::Index>(i % 3)] =
                    static_cast<double>(whole[i]) - static_cast<double>(said[i]);
            }
            for (const Vector3d& v : field_.added_up(turns)) squares += v.squaredNorm();
        }
        return squares;
    }

    TurnField field_;
    MatrixXd codes_;
    BallComponents truth_;
    MetricRows turns_;
};

TEST_F(TurnFitTest, WhatMadeTheShapesStays) {
    const BallComponents found = fitted_to_carry(field_, turns_, codes_, truth_);
    for (std::size_t i = 0; i < found.all_values().size(); ++i) {
        EXPECT_NEAR(found.all_values()[i], truth_.all_values()[i], 1e-5);
    }
}

// Of turns that are cut off at two edges of three, what they carry is made good for at the third.
TEST_F(TurnFitTest, WhatIsCutOffIsMadeGoodForWhereAComponentIsLeft) {
    BallComponents cut(field_.edge_count(), balls(3), 3);
    for (int k = 0; k < kFitComponents; ++k) {
        const std::vector<float> all = truth_.component(k);
        std::vector<float> some;
        for (std::size_t e = 0; e < at(field_.edge_count()); e += 3) {
            some.insert(some.end(), all.begin() + static_cast<std::ptrdiff_t>(3 * e),
                        all.begin() + static_cast<std::ptrdiff_t>(3 * e + 3));
        }
        cut.set_component(k, some);
    }
    const BallComponents found = fitted_to_carry(field_, turns_, codes_, cut);
    EXPECT_LT(left(found), 0.2 * left(cut));
    EXPECT_EQ(found.balls()[0].vertices, cut.balls()[0].vertices);
}

TEST_F(TurnFitTest, NothingStaysNothing) {
    BallComponents none(field_.edge_count(), std::vector<Ball>(kFitComponents), 3);
    EXPECT_EQ(fitted_to_carry(field_, turns_, codes_, none).all_values().size(), 0U);
    const MetricRows still(field_.edge_count(), kFitShapes, 3);
    const BallComponents zero(field_.edge_count(), balls(1), 3);
    const BallComponents resting = fitted_to_carry(field_, still, codes_, zero);
    for (const float x : resting.all_values()) EXPECT_EQ(x, 0);
    const BallComponents unused =
        fitted_to_carry(field_, turns_, MatrixXd::Zero(kFitShapes, kFitComponents), truth_);
    for (const float x : unused.all_values()) EXPECT_TRUE(std::isfinite(x));
}

}  // namespace
}  // namespace mscomp
