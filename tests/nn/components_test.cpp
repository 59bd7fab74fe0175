// SPDX-License-Identifier: MIT
#include "mscomp/model/components.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "network_files.h"
#include "nn/start.h"
#include "op_table.h"
#include "shapes.h"
#include "small_spectral.h"
#include "small_training.h"
#include "two_components.h"

namespace mscomp::nn {
namespace {

class ByHand : public testing::Test {
  protected:
    std::vector<Component> all(const FilterConfig& filter = {}) {
        return extract_components(*hand_.network, hand_.codes, filter, hand_.line);
    }
    Component first(FilterConfig filter = {}) { return all(filter).front(); }
    /// Length of the change of vertex 0, 2 and 3 between the reference and code 2 of component 0.
    double at_vertex_0() const {
        return std::abs(std::tanh(0.5 * 2 + 0.25 * 0.05) - std::tanh(0.5 * 0.1 + 0.25 * 0.05)) /
               0.5;
    }
    double at_vertex_2() const { return (std::tanh(2.0) - std::tanh(0.1)) / 0.5; }
    double at_vertex_3() const { return (std::tanh(0.008) - std::tanh(0.0004)) / 0.5; }

    TwoComponents hand_;
};

// The code of the reference is what the encoder gives for it: 0.5 * 0.2 here.
TEST_F(ByHand, CodesSpanTheTrainingShapesAndTheReference) {
    const auto components = all();
    ASSERT_EQ(components.size(), 2U);
    EXPECT_NEAR(components[0].code_reference, 0.1, 1e-6);
    EXPECT_EQ(components[0].code_min, -0.5);
    EXPECT_EQ(components[0].code_max, 2.0);
    EXPECT_EQ(components[0].code_end, 2.0);  // moves the shape more than -0.5 does
    EXPECT_EQ(components[0].code_other, -0.5);
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

// Both ends: at -0.5 vertex 2 is tanh(-0.5), at the reference tanh(0.1), of half the size.
TEST_F(ByHand, OtherDifferenceIsThatOfTheOtherEnd) {
    const Component c = first();
    EXPECT_NEAR(c.other_difference[2 * 9 + 4], (std::tanh(-0.5) - std::tanh(0.1)) / 0.5, 1e-6);
    EXPECT_NEAR(c.other_difference[0], (std::tanh(-0.25 + 0.0125) - std::tanh(0.05 + 0.0125)) / 0.5,
                1e-6);
    EXPECT_EQ(c.other_difference[9], 0.0F);
}

// [B] 5.1: |Dec(z_end) - Dec(z_r)| over all features, unscaled.
TEST_F(ByHand, DistanceIsThatOfTheEndFromTheReference) {
    const std::vector<Component> both = all();
    EXPECT_NEAR(both[0].distance, std::hypot(at_vertex_0(), at_vertex_2(), at_vertex_3()), 1e-6);
    const double farther = std::tanh(0.05 + 0.25 * 0.05) - std::tanh(0.05);  // its end is 0
    EXPECT_NEAR(both[1].distance, farther / 0.5, 1e-6);
    EXPECT_EQ(both[0].code, 0);
    EXPECT_EQ(both[1].code, 1);
}

// Coarse to fine, then by distance; ids and equal ones keep their order.
TEST(Components, StrongestFirstIsByDistanceWithinALevel) {
    std::vector<Component> components(6);
    const std::array<int, 6> levels{0, 0, 0, 1, 1, 1};
    const std::array<double, 6> distances{1, 3, 2, 5, 9, 5};
    for (std::size_t i = 0; i < 6; ++i) {
        components[i].level = levels[i];
        components[i].distance = distances[i];
        components[i].strength = -distances[i];
    }
    EXPECT_EQ(strongest_first(components), (std::vector<int>{1, 2, 0, 4, 3, 5}));
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
    Network network(model, around_reference(1));
    const CodeTable codes{network.code_count(),
                          std::vector<float>(static_cast<std::size_t>(network.code_count()), 1.0F)};
    return extract_components(network, codes, {}, line);
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
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 20; ++epoch) trainer.run_epoch();
    Network network(*model, around_reference(0.5));
    const auto components = extract_components(network, trainer.codes(), {}, problem.distances);
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

/// Edges between each vertex and `from`.
std::vector<int> ring_distances(const TriangleMesh& mesh, int from) {
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    std::vector<int> distance(mesh.vertices.size(), -1), next{from};
    distance[static_cast<std::size_t>(from)] = 0;
    for (std::size_t i = 0; i < next.size(); ++i) {
        const auto v = static_cast<std::size_t>(next[i]);
        for (int n = rings.offsets[v]; n < rings.offsets[v + 1]; ++n) {
            const int other = rings.neighbors[static_cast<std::size_t>(n)];
            if (distance[static_cast<std::size_t>(other)] >= 0) continue;
            distance[static_cast<std::size_t>(other)] = distance[v] + 1;
            next.push_back(other);
        }
    }
    return distance;
}

/// How many rings around `vertex`, its whole support, component 0 changes features, exactly.
int rings_changed(Model<float>& model, const TriangleMesh& mesh, int vertex) {
    ParameterSet<float>& parameters = model.parameters();
    for (int i = 0; i < parameters.count(); ++i) std::ranges::fill(parameters.value(i), 0.3F);
    const int index = model.component_weights(0);
    std::vector<float> weights(parameters.value(index).size(), 0.0F);
    for (int c = 0; c < 9; ++c) weights[static_cast<std::size_t>(vertex * 9 + c)] = 0.5F;
    model.from_user_order(index, weights, parameters.value(index));
    const Network network(model, around_reference(1));
    std::vector<float> codes(static_cast<std::size_t>(network.code_count()), 0.0F), moved = codes;
    moved[0] = 1;
    const std::vector<float> change = network.change(moved, codes);
    const std::vector<int> distance = ring_distances(mesh, vertex);
    int rings = 0;
    for (std::size_t i = 0; i < change.size(); ++i) {
        if (change[i] != 0) rings = std::max(rings, distance[i / 9]);
    }
    return rings;
}

// A convolution over one ring looks one ring far, Chebyshev filters of order H look H - 1.
TEST(Components, MoveTheSupportAndWhatTheConvolutionSees) {
    SmallTraining problem;
    problem.config.stacked.levels = {{1, 0.3, 1.0, {}}};
    EXPECT_EQ(rings_changed(*problem.make_model(), problem.mesh, 5), 1);
    problem.config.spectral.components = 1;
    for (const int order : {1, 2, 3, 4}) {
        problem.config.spectral.filter_order = order;
        EXPECT_EQ(rings_changed(*make_vae<float>(problem), problem.mesh, 5), order - 1);
    }
}

// Whatever the unit or the resolution: beside the strongest. 0 is the paper, which has no such
// rule.
TEST_F(ByHand, WeakOnesBesideTheStrongestAreDropped) {
    FilterConfig filter;
    filter.rule = FilterRule::strength;
    filter.minimum_strength = 0;
    filter.minimum_share = 0;
    const double most = all(filter)[0].strength, least = all(filter)[1].strength;
    ASSERT_TRUE(0 < least && least < most) << least << ", " << most;
    for (const double share : {0.0, 0.99 * least / most, 1.01 * least / most, 1.0}) {
        filter.minimum_share = share;
        for (const Component& c : all(filter)) {
            EXPECT_EQ(c.kept, c.strength >= share * most) << share << " " << c.strength;
            EXPECT_EQ(c.kept, c.reason.empty());
        }
    }
}

TEST(Components, BelowTheMinimumStrengthAreDroppedWithAReason) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    Network network(*model, around_reference(1));
    FilterConfig filter;
    filter.rule = FilterRule::strength;
    filter.minimum_strength = 1e9;
    for (const Component& c :
         extract_components(network, trainer.codes(), filter, problem.distances)) {
        EXPECT_FALSE(c.kept);
        EXPECT_FALSE(c.reason.empty());
    }
}

}  // namespace
}  // namespace mscomp::nn
