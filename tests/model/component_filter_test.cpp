// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <cmath>

#include "linear_model.h"
#include "mscomp/model/components.h"
#include "mscomp/model/synthesis.h"

namespace mscomp {
namespace {

using cases::LinearModel;
using cases::NoDistances;
using cases::normal_numbers;
using cases::table_of;
using Eigen::Index;
using Eigen::MatrixXd;
using testing::HasSubstr;
using testing::StartsWith;

/// Three vertices; codes of the reference that are not 0.
struct FilterCase {
    MatrixXd changes = normal_numbers(27, 5, 1);
    MatrixXd codes = normal_numbers(30, 5, 2);
    std::vector<float> reference{0.5F, -0.25F, 0, 0.125F, 1};
    int coarse = 0;
    FilterConfig filter;

    LinearModel model() const { return LinearModel(changes, reference, coarse); }
    /// Codes from those of the reference on.
    CodeTable table() const {
        MatrixXd all = codes;
        for (Index k = 0; k < all.cols(); ++k) {
            all.col(k).array() += static_cast<double>(reference[at(k)]);
        }
        return table_of(all);
    }
    std::vector<Component> components() const {
        LinearModel own = model();
        NoDistances none(3);
        return extract_components(own, table(), filter, none);
    }
};

TEST(ComponentFilter, KeepsWhatIsNeededWithWhatItCosts) {
    for (const Component& c : FilterCase().components()) {
        EXPECT_TRUE(c.kept);
        EXPECT_EQ(c.reason, "");
        EXPECT_GT(c.cost, 0.01);
        EXPECT_LT(c.cost, 1);
    }
}

// A component that is the sum of two others is not needed, whichever of the three it is.
TEST(ComponentFilter, DropsWhatTheOthersMakeUpForAndSaysSo) {
    FilterCase shapes;
    shapes.changes.col(4) = shapes.changes.col(0) + shapes.changes.col(1);
    shapes.codes.col(4) *= 0.1;
    const auto components = shapes.components();
    EXPECT_FALSE(components[4].kept);
    EXPECT_THAT(components[4].reason, HasSubstr("the others lose"));
    EXPECT_LT(components[4].cost, 1e-6);
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(components[at(k)].kept) << k;
}

TEST(ComponentFilter, SaysWhatTheShapesDoNotMove) {
    FilterCase shapes;
    shapes.codes.col(1).setZero();
    shapes.changes.col(3).setZero();
    const auto components = shapes.components();
    EXPECT_EQ(components[1].reason, "the training shapes do not move it");
    EXPECT_EQ(components[3].reason, "no vertex is left in its support");
}

/// Code 4 goes -0.5 times as far as code 2.
FilterCase going_together() {
    FilterCase shapes;
    shapes.codes.col(4) = -0.5 * shapes.codes.col(2);
    shapes.changes.col(4) *= 0.3;
    return shapes;
}

// The stronger one stands for both: its ends move both codes, and are what synthesis makes of it.
TEST(ComponentFilter, AMergedComponentMovesAlong) {
    const FilterCase shapes = going_together();
    const auto components = shapes.components();
    EXPECT_FALSE(components[4].kept);
    EXPECT_EQ(components[4].merged_into, "2");
    EXPECT_THAT(components[4].reason, StartsWith("merged into 2: "));
    ASSERT_EQ(components[2].others.size(), 1U);
    EXPECT_EQ(components[2].others[0].code, 4);
    EXPECT_NEAR(components[2].others[0].ratio, -0.5, 1e-6);
    const double end = components[2].code_end - 0;
    EXPECT_NEAR(components[2].code_max, shapes.codes.col(2).maxCoeff(), 1e-5);
    EXPECT_NEAR(components[2].code_min, shapes.codes.col(2).minCoeff(), 1e-5);
    for (Index i = 0; i < 27; ++i) {
        EXPECT_NEAR(components[2].difference[at(i)],
                    end * (shapes.changes(i, 2) - 0.5 * shapes.changes(i, 4)), 1e-5);
    }
    const LinearModel model = shapes.model();
    const Synthesis synthesis(model, components);
    const auto codes = synthesis.codes(std::vector<ComponentWeight>{{2, 1.0}});
    EXPECT_EQ(synthesis.change(codes), components[2].difference);
    EXPECT_NEAR(codes[4], 1 - 0.5 * end, 1e-5);
    EXPECT_EQ(codes[0], 0.5F);
}

// One that moves along may have a weight of its own, too; in whatever order they are given.
TEST(ComponentFilter, WeightsOfAMergedComponentAddUp) {
    const FilterCase shapes = going_together();
    const auto components = shapes.components();
    const LinearModel model = shapes.model();
    const Synthesis synthesis(model, components);
    const ComponentWeight leader{2, 0.5}, other{4, 0.25};
    const auto codes = synthesis.codes(std::vector<ComponentWeight>{leader, other});
    EXPECT_EQ(synthesis.codes(std::vector<ComponentWeight>{other, leader}), codes);
    const double along = -0.5 * 0.5 * (components[2].code_end - components[2].code_reference);
    const double own = 0.25 * (components[4].code_end - components[4].code_reference);
    EXPECT_NEAR(codes[4], 1 + along + own, 1e-5);
}

// The rule of the papers leaves out by strength alone, and says what that costs.
TEST(ComponentFilter, TheRuleOfThePapersIsByStrength) {
    FilterCase shapes = going_together();
    shapes.codes.col(0) *= 1e-2;
    shapes.filter.rule = FilterRule::strength;
    const auto components = shapes.components();
    for (int k = 1; k < 5; ++k) EXPECT_TRUE(components[at(k)].kept) << k;
    EXPECT_THAT(components[0].reason, HasSubstr("of the strongest"));
    EXPECT_GT(components[0].cost, 0);
    EXPECT_LT(components[0].cost, 1e-3);
    EXPECT_TRUE(components[2].others.empty());
}

// As much as the share says of what the model is wrong by, and no more.
TEST(ComponentFilter, ShareIsOneOfTheErrorOfTheTrainingShapes) {
    FilterCase shapes;
    shapes.codes.col(3) *= 0.1;
    LinearModel model = shapes.model();
    NoDistances none(3);
    const double cost = shapes.components()[3].cost;
    const double squares = (shapes.changes * shapes.codes.transpose()).squaredNorm();
    shapes.filter.refit_share = 0.25;
    for (const double factor : {0.99, 1.01}) {
        const auto components = extract_components(model, shapes.table(), shapes.filter, none, {},
                                                   factor * cost * squares / 0.25);
        EXPECT_EQ(components[3].kept, factor < 1);
        for (const int k : {0, 1, 2, 4}) EXPECT_TRUE(components[at(k)].kept) << k;
        if (factor < 1) continue;
        EXPECT_THAT(components[3].reason, HasSubstr("25 % of the error"));
    }
}

// Channels that the metric does not count cost nothing.
TEST(ComponentFilter, CountsErrorsAsTheMetricDoes) {
    FilterCase shapes;
    for (Index i = 0; i < 27; ++i) {
        if (i % 9 < 3) shapes.changes.row(i).head(4).setZero();
        if (i % 9 >= 3) shapes.changes(i, 4) = 0;
    }
    ASSERT_TRUE(shapes.components()[4].kept);
    MetricScale metric;
    for (std::size_t c = 0; c < 3; ++c) metric.factor[c] = 1e-4;
    LinearModel model = shapes.model();
    NoDistances none(3);
    const auto components = extract_components(model, shapes.table(), {}, none, metric);
    EXPECT_FALSE(components[4].kept);
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(components[at(k)].kept) << k;
}

}  // namespace
}  // namespace mscomp
