// SPDX-License-Identifier: MIT
#include "nn/start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/random.h"
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

/// Two patches around opposite vertices, each along one channel of its own. Their atanh is what the
/// model sees, so that the encoder gives exactly two directions.
void fill_with_two_directions(SmallTraining& problem) {
    const CounterRandom random(23, 0);
    const int vertices = problem.mesh.vertex_count();
    std::ranges::fill(problem.features, 0.0F);
    for (std::size_t m = 0; m < problem.shapes.size(); ++m) {
        for (const int p : {0, 3}) {
            const double code = 2 * random.uniform(m * 4 + static_cast<std::size_t>(p)) - 1;
            const auto distance = problem.distances.row(p);
            for (int v = 0; v < vertices; ++v) {
                const double bump = std::max(0.0, 1 - distance[static_cast<std::size_t>(v)] / 0.25);
                float& x = problem.features[(m * static_cast<std::size_t>(vertices) +
                                             static_cast<std::size_t>(v)) *
                                                9 +
                                            static_cast<std::size_t>(p)];
                if (bump > 0) x = static_cast<float>(std::atanh(0.7 * code * bump));
            }
        }
    }
}

// What two components explain leaves the other three exactly zero, instead of rows of unit length
// along rounding.
TEST(DeflationStart, StopsWhereEverythingIsExplained) {
    SmallTraining problem;
    fill_with_two_directions(problem);
    problem.config.stacked.levels = {{5, 0.3, 1.0, {}}};
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    const std::span<const float> weights = model->parameters().value(model->levels()[0].weights);
    for (int row = 0; row < 5; ++row) {
        const double length = row_length(weights, row, model->vertex_count());
        if (row < 2) {
            EXPECT_NEAR(length, 1, 1e-5);
        } else {
            EXPECT_EQ(length, 0) << "row " << row;
        }
    }
    std::vector<int> centers = model->centers(0);
    std::sort(centers.begin(), centers.begin() + 2);
    EXPECT_EQ(centers[0], 0);
    EXPECT_EQ(centers[1], 3);
    for (const int center : centers) EXPECT_TRUE(center >= 0 && center < model->vertex_count());
    EXPECT_TRUE(std::isfinite(trainer.run_epoch().total));
    for (const float x : all_of(*model)) EXPECT_TRUE(std::isfinite(x));
}

// The start looks at all shapes, however few of them make a batch.
TEST(DeflationStart, DoesNotDependOnTheBatch) {
    SmallTraining problem;
    const auto whole = problem.make_model();
    start_deflation(*whole, std::span<const float>(problem.features),
                    std::span<const int>(problem.shapes));
    const std::span<const float> expected = whole->parameters().all_values();
    for (const int batch : {1, 2, 5}) {
        problem.config.train.batch = batch;
        const auto model = problem.make_model();
        ASSERT_EQ(model->batch_capacity(), batch);
        start_deflation(*model, std::span<const float>(problem.features),
                        std::span<const int>(problem.shapes));
        for (int level = 0; level < 2; ++level) {
            EXPECT_EQ(model->centers(level), whole->centers(level)) << "batch " << batch;
        }
        const std::span<const float> got = model->parameters().all_values();
        ASSERT_EQ(got.size(), expected.size());
        for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], expected[i], 1e-5);
    }
}

// A decoder of its own starts as the encoder's transpose, the identity, so that tying changes
// nothing yet.
TEST(DeflationStart, StartsADecoderOfItsOwnAsTheIdentity) {
    SmallTraining problem;
    const auto loss_and_matrices = [&](Tied tied) {
        problem.config.stacked.tied = tied;
        const auto model = problem.make_model();
        start_deflation(*model, std::span<const float>(problem.features),
                        std::span<const int>(problem.shapes));
        for (const auto& level : model->levels()) {
            EXPECT_EQ(level.decoder_w_own != level.w_own, tied == Tied::none);
            for (const int index : {level.w_own, level.decoder_w_own}) {
                const std::span<const float> w = model->parameters().value(index);
                for (std::size_t i = 0; i < w.size(); ++i) {
                    EXPECT_EQ(w[i], i % 81 / 9 == i % 9 ? 1.0F : 0.0F);
                }
            }
            for (const int index :
                 {level.w_ring, level.decoder_w_ring, level.bias, level.decoder_bias}) {
                for (const float x : model->parameters().value(index)) EXPECT_EQ(x, 0.0F);
            }
        }
        model->load_batch(std::span<const float>(problem.features),
                          std::span<const int>(problem.shapes));
        return model->forward();
    };
    const float tied = loss_and_matrices(Tied::transpose);
    EXPECT_TRUE(tied > 0);
    EXPECT_EQ(loss_and_matrices(Tied::none), tied);
}

// Data that do not move leave all components zero and the model finite.
TEST(DeflationStart, OfShapesThatDoNotMoveIsFinite) {
    SmallTraining problem;
    std::fill(problem.features.begin(), problem.features.end(), 0.0F);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
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

}  // namespace
}  // namespace mscomp::nn
