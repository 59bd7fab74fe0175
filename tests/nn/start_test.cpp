// SPDX-License-Identifier: MIT
#include "mscomp/nn/start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mscomp/nn/components.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

double row_length(std::span<const float> weights, int row, int vertices) {
    double sum = 0;
    for (int i = row * vertices * 9; i < (row + 1) * vertices * 9; ++i) {
        sum += static_cast<double>(weights[static_cast<std::size_t>(i)]) *
               static_cast<double>(weights[static_cast<std::size_t>(i)]);
    }
    return std::sqrt(sum);
}

// Rows have unit length and vanish outside the sparsity range of their centre, at every level.
TEST(DeflationStart, GivesUnitRowsWithExactSupports) {
    SmallTraining problem;
    const auto model = problem.make_model();
    start_deflation(*model, std::span<const float>(problem.features),
                    std::span<const int>(problem.shapes));
    const int vertices = model->vertex_count();
    for (const auto& level : model->levels()) {
        const std::span<const float> weights = model->parameters().value(level.weights);
        const int rows = level.autoencoders * level.components;
        const std::vector<int>& centers = level.sparsity->centers();
        for (int row = 0; row < rows; ++row) {
            EXPECT_NEAR(row_length(weights, row, vertices), 1, 1e-5);
            const SparsityRow around = level.sparsity->row(centers[static_cast<std::size_t>(row)]);
            for (int v = 0; v < vertices; ++v) {
                if (around.is_free(v)) continue;
                for (int c = 0; c < 9; ++c) {
                    EXPECT_EQ(weights[static_cast<std::size_t>((row * vertices + v) * 9 + c)],
                              0.0F);
                }
            }
        }
    }
}

// Three patches that do not overlap: the three components find them, one each.
TEST(DeflationStart, FindsSeparatePatches) {
    SmallTraining problem(20, 3);
    const auto model = problem.make_model();
    start_deflation(*model, std::span<const float>(problem.features),
                    std::span<const int>(problem.shapes));
    std::vector<int> centers = model->centers(0);
    std::sort(centers.begin(), centers.end());
    EXPECT_EQ(centers, (std::vector<int>{0, 1, 2}));
}

// Data that do not move leave all components zero and the model finite.
TEST(DeflationStart, OfShapesThatDoNotMoveIsFinite) {
    SmallTraining problem;
    std::fill(problem.features.begin(), problem.features.end(), 0.0F);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    EXPECT_TRUE(std::isfinite(trainer.run_epoch().total));
    for (const float x : all_of(*model)) EXPECT_TRUE(std::isfinite(x));
}

TEST(RandomStart, HasTheDeviationOfThePaper) {
    SmallTraining problem;
    const auto model = problem.make_model();
    start_random(*model, 3);
    const std::span<const float> weights = model->parameters().value(model->levels()[0].weights);
    double squares = 0;
    for (const float x : weights) squares += static_cast<double>(x) * static_cast<double>(x);
    const double count = static_cast<double>(weights.size());
    // The variance of n normals is within 5 sqrt(2/n) of 0.02^2.
    EXPECT_NEAR(squares / count / 4e-4, 1, 5 * std::sqrt(2 / count));
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
            problem.config.model.levels[static_cast<std::size_t>(c.level)].sparsity_range;
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
