// SPDX-License-Identifier: MIT
#include "mscomp/nn/components.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "mscomp/nn/start.h"
#include "op_table.h"
#include "shapes.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

/// A line of five vertices 1/4 apart and two components that overlap at vertex 0. Convolutions are
/// the identity, so codes and features can be written down: z_k = sum C_k tanh(x), tanh(sum C_k
/// z_k).
class ByHand : public testing::Test {
  protected:
    ByHand() {
        config_.levels = {{2, 1.0, 1.0, {}}};
        model_ = std::make_unique<StackedModel<float>>(
            config_, LossConfig{}, one_rings_of_faces(5, {{0, 1, 2}, {2, 3, 4}}), line_,
            StackedModel<float>::Options{});
    }

    void SetUp() override {
        const auto& level = model_->levels()[0];
        std::vector<float> weights(std::size_t{2} * 5 * 9, 0.0F);
        weights[0] = 0.5F;          // component 0: vertex 0, channel 0,
        weights[2 * 9 + 4] = 1.0F;  // vertex 2, channel 4, the longest,
        weights[3 * 9] = 0.004F;    // vertex 3, channel 0, hardly
        weights[5 * 9] = 0.25F;     // component 1: vertex 0, channel 0
        ParameterSet<float>& parameters = model_->parameters();
        model_->from_user_order(level.weights, weights, parameters.value(level.weights));
        for (std::size_t i = 0; i < 81; i += 10) parameters.value(level.w_own)[i] = 1;
        model_->set_centers(0, {1, 0});  // inside the range of every vertex: they stay
        reference_[0] = static_cast<float>(std::atanh(0.2));
        factor_.fill(0.5);
    }

    Component first(FilterConfig filter = {}) {
        return extract_components(*model_, codes_, reference_, factor_, filter, line_).front();
    }
    /// Length of the change of vertex 0, 2 and 3 between the reference and code 2 of component 0.
    double at_vertex_0() const {
        return std::abs(std::tanh(0.5 * 2 + 0.25 * 0.05) - std::tanh(0.5 * 0.1 + 0.25 * 0.05)) /
               0.5;
    }
    double at_vertex_2() const { return (std::tanh(2.0) - std::tanh(0.1)) / 0.5; }
    double at_vertex_3() const { return (std::tanh(0.008) - std::tanh(0.0004)) / 0.5; }

    LineDistances line_{5};
    StackedConfig config_;
    std::unique_ptr<StackedModel<float>> model_;
    std::vector<float> reference_ = std::vector<float>(45, 0.0F);
    std::array<double, 9> factor_{};
    /// Two shapes, (n, K).
    std::vector<std::vector<float>> codes_{{-0.5F, 0.0F, 2.0F, 0.0F}};
};

// The code of the reference is what the encoder gives for it: 0.5 * 0.2 here.
TEST_F(ByHand, CodesSpanTheTrainingShapesAndTheReference) {
    const auto components = extract_components(*model_, codes_, reference_, factor_, {}, line_);
    ASSERT_EQ(components.size(), 2U);
    EXPECT_NEAR(components[0].code_reference, 0.1, 1e-6);
    EXPECT_EQ(components[0].code_min, -0.5);
    EXPECT_EQ(components[0].code_max, 2.0);
    EXPECT_EQ(components[0].code_end, 2.0);  // moves the shape more than -0.5 does
    EXPECT_NEAR(components[1].code_reference, 0.05, 1e-6);
    EXPECT_EQ(components[1].code_min, 0.0);
    EXPECT_NEAR(components[1].code_max, 0.05, 1e-6);
}

// The centre is the settled one, whichever vertex is longest.
TEST_F(ByHand, CentreLongestAndSupport) {
    const Component c = first();
    EXPECT_EQ(c.center, 1);
    EXPECT_EQ(c.longest, 2);
    EXPECT_EQ(c.support, 3);
    EXPECT_EQ(c.moving, 3);
}

// X_r + Dec(z_end) - Dec(z_r), unscaled, the other entries of the code staying at the reference's.
TEST_F(ByHand, DifferenceIsThatOfTheDecodedFeatures) {
    const Component c = first();
    EXPECT_NEAR(c.difference[0], at_vertex_0(), 1e-6);
    EXPECT_NEAR(c.difference[2 * 9 + 4], at_vertex_2(), 1e-6);
    EXPECT_NEAR(c.difference[3 * 9], at_vertex_3(), 1e-6);
    EXPECT_EQ(c.difference[9], 0.0F);
}

// [A] eq. 7: the mean length over the vertices above 1 % of the peak, here 0 and 2.
TEST_F(ByHand, StrengthIsTheMeanOverActingVertices) {
    const Component c = first();
    EXPECT_NEAR(c.strength, (at_vertex_0() + at_vertex_2()) / 2, 1e-6);
    EXPECT_NEAR(c.localization_radius, 0.25, 1e-12);
    EXPECT_TRUE(c.kept);
}

// A threshold of its own replaces the relative one.
TEST_F(ByHand, AbsoluteThresholdReplacesTheRelativeOne) {
    FilterConfig filter;
    filter.absolute_threshold = 1e-6;
    const Component all = first(filter);
    EXPECT_NEAR(all.strength, (at_vertex_0() + at_vertex_2() + at_vertex_3()) / 3, 1e-6);
    EXPECT_NEAR(all.localization_radius, 0.5, 1e-12);
    filter.absolute_threshold = (at_vertex_0() + at_vertex_2()) / 2;
    EXPECT_NEAR(first(filter).strength, at_vertex_2(), 1e-6);
}

// Mean share of the vertices of one level, dropped components included.
TEST(Components, MeanSupportIsThatOfTheirLevel) {
    std::vector<Component> components(4);
    components[0].support = 10;
    components[1].support = 30;
    components[1].kept = false;
    components[2].level = components[3].level = 1;
    components[2].support = 5;
    EXPECT_DOUBLE_EQ(mean_support(components, 0, 100), 0.2);
    EXPECT_DOUBLE_EQ(mean_support(components, 1, 100), 0.025);
    EXPECT_EQ(mean_support(components, 2, 100), 0);
}

std::vector<Component> untrained(const StackedConfig& config) {
    const TriangleMesh mesh = shapes::grid(3, 3);
    LineDistances line(9);
    StackedModel<float> model(config, {}, one_rings_of_faces(9, mesh.faces), line,
                              StackedModel<float>::Options{});
    start_random(model, 1);
    std::array<double, 9> factor{};
    factor.fill(1);
    std::vector<std::vector<float>> codes;
    for (const auto& level : model.levels()) {
        codes.emplace_back(static_cast<std::size_t>(level.autoencoders * level.components), 1.0F);
    }
    return extract_components(model, codes, std::vector<float>(81, 0.0F), factor, {}, line);
}

std::vector<std::string> ids(const std::vector<Component>& components) {
    std::vector<std::string> result;
    for (const Component& c : components) result.push_back(c.parent + "<" + c.id);
    return result;
}

// Ids are paths from the coarsest level; the children of a component follow one another.
TEST(Components, IdsOfThreeLevelsArePaths) {
    StackedConfig config;
    config.levels = {{2, 0.5, 1.0, {}}, {3, 0.5, 1.0, {}}, {2, 0.5, 1.0, {}}};
    std::vector<std::string> expected{"<0", "<1"};
    for (const char* parent : {"0", "1"}) {
        for (const char* index : {"0", "1", "2"}) {
            expected.push_back(std::string(parent) + "<" + parent + "." + index);
        }
    }
    for (const char* parent : {"0.0", "0.1", "0.2", "1.0", "1.1", "1.2"}) {
        for (const char* index : {"0", "1"}) {
            expected.push_back(std::string(parent) + "<" + parent + "." + index);
        }
    }
    EXPECT_EQ(ids(untrained(config)), expected);
}

// Without attention a level refines the whole and has no parents.
TEST(Components, IdsWithoutAttentionNameTheLevel) {
    StackedConfig config;
    config.attention = false;
    config.levels = {{2, 0.5, 1.0, {}}, {2, 0.5, 1.0, {}}, {1, 0.5, 1.0, {}}};
    EXPECT_EQ(ids(untrained(config)),
              (std::vector<std::string>{"<0", "<1", "<L1.0", "<L1.1", "<L2.0"}));
}

// A trained component moves nothing outside its range and one ring around it, and the end it shows
// is one of its two code ends.
TEST(Components, MoveNothingFarFromTheirSupport) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 20; ++epoch) trainer.run_epoch();
    const auto codes = trainer.codes();
    std::array<double, 9> factor{};
    factor.fill(0.5);
    const std::vector<float> reference(static_cast<std::size_t>(model->vertex_count()) * 9, 0.0F);
    const auto components =
        extract_components(*model, codes, reference, factor, {}, problem.distances);
    ASSERT_EQ(components.size(), 3u + 6u);
    for (const Component& c : components) {
        EXPECT_TRUE(c.code_end == c.code_min || c.code_end == c.code_max);
        EXPECT_EQ(c.parent.empty(), c.level == 0);
        const auto distance = problem.distances.row(c.center);
        const double range =
            problem.config.stacked.levels[static_cast<std::size_t>(c.level)].sparsity_range;
        EXPECT_LE(c.localization_radius,
                  range + 0.12);  // one edge of the sphere is at most 0.11 pi
        for (int v = 0; v < model->vertex_count(); ++v) {
            if (distance[static_cast<std::size_t>(v)] < range + 0.12) continue;
            for (int i = 0; i < 9; ++i) {
                EXPECT_EQ(c.difference[static_cast<std::size_t>(v * 9 + i)], 0.0F) << c.id;
            }
        }
    }
    EXPECT_EQ(components[3].id, "0.0");
    EXPECT_EQ(components[8].id, "2.1");
    EXPECT_EQ(components[8].parent, "2");
}

TEST(Components, BelowTheMinimumStrengthAreDroppedWithAReason) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    std::array<double, 9> factor{};
    factor.fill(1.0);
    FilterConfig filter;
    filter.minimum_strength = 1e9;
    const std::vector<float> reference(static_cast<std::size_t>(model->vertex_count()) * 9, 0.0F);
    for (const Component& c : extract_components(*model, trainer.codes(), reference, factor, filter,
                                                 problem.distances)) {
        EXPECT_FALSE(c.kept);
        EXPECT_FALSE(c.reason.empty());
    }
}

}  // namespace
}  // namespace mscomp::nn
