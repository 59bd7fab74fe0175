// SPDX-License-Identifier: MIT
// The vertices that a level touches: which they are, and that leaving out the others is exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "nn/active_vertices.h"
#include "nn/optimizer.h"
#include "nn/parameter_set.h"
#include "nn/start.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

using Range = ParameterSet<double>::Range;

TEST(ActiveVertices, AreThoseThatActAndTheRingAround) {
    const TriangleMesh mesh = shapes::grid(9, 7);
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    std::vector<std::uint8_t> acts(static_cast<std::size_t>(mesh.vertex_count()), 0);
    acts[30] = acts[31] = 1;
    const ActiveVertices active = ActiveVertices::around(rings, acts);
    EXPECT_EQ(active.acting_vertices, (std::vector<int>{30, 31}));
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const auto first = rings.neighbors.begin() + rings.offsets[static_cast<std::size_t>(v)];
        const auto last = rings.neighbors.begin() + rings.offsets[static_cast<std::size_t>(v) + 1];
        const bool sees =
            std::any_of(first, last, [&](int j) { return acts[static_cast<std::size_t>(j)] != 0; });
        const int slot = active.slot_of[static_cast<std::size_t>(v)];
        EXPECT_EQ(slot >= 0, sees || active.acts(v)) << v;
        if (slot < 0) continue;
        EXPECT_EQ(active.vertices[static_cast<std::size_t>(slot)], v);
    }
    // Where a vertex acts its whole ring has slots.
    for (const int slot : active.acting) {
        const auto s = static_cast<std::size_t>(slot);
        EXPECT_EQ(active.ring_offsets[s + 1] - active.ring_offsets[s],
                  rings.degree(active.vertices[s]));
    }
}

TEST(ParameterSet, LivePiecesHoldExactlyWhatIsLive) {
    ParameterSet<double> parameters;
    parameters.add("a", {100});
    const int b = parameters.add("b", {100000});
    parameters.set_live(b, {{5, 7}, {100, 70000}});
    std::vector<int> seen(parameters.all_values().size(), 0);
    for (int piece = 0; piece < parameters.live_piece_count(); ++piece) {
        for (const Range& range : parameters.live_piece(piece)) {
            for (std::int64_t i = range.first; i < range.last; ++i) {
                ++seen[static_cast<std::size_t>(i)];
            }
        }
    }
    const std::int64_t offset = parameters.entry(b).offset;
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(seen.size()); ++i) {
        const std::int64_t in_b = i - offset;
        const bool is_live = i < 100 || (in_b >= 5 && in_b < 7) || (in_b >= 100 && in_b < 70000);
        EXPECT_EQ(seen[static_cast<std::size_t>(i)], is_live ? 1 : 0) << i;
    }
}

// What stops being live leaves zeros: dense Adam over a zero gradient and zero moments would leave
// it alone too.
TEST(ParameterSet, ForgetsWhatStopsBeingLive) {
    ParameterSet<double> parameters;
    const int a = parameters.add("a", {40});
    parameters.set_live(a, {{0, 10}, {20, 40}});
    for (auto all :
         {parameters.all_grads(), parameters.all_moments1(), parameters.all_moments2()}) {
        for (const auto& [first, last] : {Range{0, 10}, Range{20, 40}}) {
            std::fill(all.begin() + first, all.begin() + last, 3.0);
        }
    }
    parameters.set_live(a, {{4, 25}, {30, 31}});
    for (std::int64_t i = 0; i < 40; ++i) {
        const bool kept = (i >= 4 && i < 10) || (i >= 20 && i < 25) || i == 30;
        const auto at = static_cast<std::size_t>(i);
        EXPECT_EQ(parameters.all_grads()[at], kept ? 3.0 : 0.0) << i;
        EXPECT_EQ(parameters.all_moments1()[at], kept ? 3.0 : 0.0) << i;
        EXPECT_EQ(parameters.all_moments2()[at], kept ? 3.0 : 0.0) << i;
    }
}

/// Of both errors that the last level can have.
class Supports : public testing::TestWithParam<LossTarget> {
  protected:
    Supports() {
        problem_.config.train.epochs = 10;
        problem_.config.loss.target = GetParam();
        model_ = problem_.make_model();
    }
    StackedModel<float>& model() { return *model_; }
    std::span<float> weights() {
        return model_->parameters().value(model_->levels().back().weights);
    }
    /// One pass with the batch loaded.
    void pass() {
        model_->load_batch(std::span<const float>(problem_.features),
                           std::span<const int>(problem_.shapes));
        model_->forward();
        model_->parameters().zero_grad();
        model_->backward();
    }
    std::int64_t count(const std::vector<std::uint8_t>& acts) {
        return std::count(acts.begin(), acts.end(), 1);
    }

    SmallTraining problem_;
    std::unique_ptr<StackedModel<float>> model_;
};

// After a start the last level acts where it has weights, and that is not everywhere.
TEST_P(Supports, BeginWhereTheStartPutsWeights) {
    start_deflation(model(), std::span<const float>(problem_.features),
                    std::span<const int>(problem_.shapes));
    const std::vector<std::uint8_t> acts = model().acting(1);
    const auto vertices = static_cast<std::size_t>(model().vertex_count());
    const std::vector<float> user = model().to_user_order(
        model().levels()[1].weights,
        std::as_const(model().parameters()).value(model().levels()[1].weights));
    for (std::size_t i = 0; i < acts.size(); ++i) {
        const std::size_t a = i / vertices, v = i % vertices;
        bool has_weights = false;
        for (std::size_t k = 0; k < 2; ++k) {
            for (std::size_t c = 0; c < 9; ++c) {
                has_weights = has_weights || user[((a * 2 + k) * vertices + v) * 9 + c] != 0;
            }
        }
        EXPECT_EQ(acts[i] != 0, has_weights) << i;
    }
    EXPECT_LT(count(acts), static_cast<std::int64_t>(acts.size()));
    EXPECT_GT(count(acts), 0);
}

// A part of a component that was cut away comes back: leaving it out costs more than is allowed.
TEST_P(Supports, GrowWhereTheGradientAsksForIt) {
    start_deflation(model(), std::span<const float>(problem_.features),
                    std::span<const int>(problem_.shapes));
    const std::vector<std::uint8_t> whole = model().acting(1);
    const std::vector<float> before(weights().begin(), weights().end());
    const auto vertices = static_cast<std::size_t>(model().vertex_count());
    // The vertex where component 0 is longest, as the user numbers it.
    std::size_t longest = 0;
    double largest = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        double square = 0;
        for (std::size_t c = 0; c < 9; ++c) square += std::pow(before[v * 9 + c], 2);
        if (square > largest) {
            largest = square;
            longest = v;
        }
    }
    for (std::size_t k = 0; k < 2; ++k) {
        std::fill_n(weights().begin() + static_cast<std::ptrdiff_t>((k * vertices + longest) * 9),
                    9, 0.0F);
    }
    model().act_where_weights_are();
    const std::size_t user = static_cast<std::size_t>(model().order().to_user[longest]);
    EXPECT_EQ(model().acting(1)[user], 0);
    pass();
    const auto change = model().adapt_supports(problem_.config.loss.sparsity, 1);
    EXPECT_GT(change.admitted, 0);
    EXPECT_EQ(model().acting(1)[user], 1);
    // Its moments are those of a gradient that has always been what it is.
    const std::span<const float> moments =
        model().parameters().moment2(model().levels()[1].weights);
    EXPECT_GT(*std::max_element(moments.begin() + static_cast<std::ptrdiff_t>(longest * 9),
                                moments.begin() + static_cast<std::ptrdiff_t>(longest * 9 + 9)),
              0.0F);
}

// Vertices without weights whose gradient is no match for the penalty are dropped.
TEST_P(Supports, ShrinkWhereNothingIsGained) {
    start_deflation(model(), std::span<const float>(problem_.features),
                    std::span<const int>(problem_.shapes));
    const std::vector<std::uint8_t> found = model().acting(1);
    model().set_acting(1, std::vector<std::uint8_t>(found.size(), 1));
    EXPECT_EQ(model().touched(1), 1.0);
    pass();
    const float dense = model().forward();
    pass();
    const auto change = model().adapt_supports(problem_.config.loss.sparsity, 1);
    EXPECT_GT(change.dropped, static_cast<std::int64_t>(found.size()) / 4);
    EXPECT_EQ(change.admitted, 0);
    EXPECT_LT(model().touched(1), 0.8);
    // What dropping costs is within what the rule allows for all vertices of all autoencoders.
    const double errors = model().term_values()[3];  // of level 1
    const double cost = static_cast<double>(model().forward()) - static_cast<double>(dense);
    EXPECT_LE(cost, StackedModel<float>::kWorthwhile * errors + 1e-5 * static_cast<double>(dense));
}

// The level that acts everywhere and the one that acts where its weights are give the same outputs.
TEST_P(Supports, AreExactWhereTheRestIsZero) {
    start_deflation(model(), std::span<const float>(problem_.features),
                    std::span<const int>(problem_.shapes));
    pass();
    const float sparse = model().forward();
    const std::vector<float> sparse_codes = model().codes(1);
    const std::vector<float> sparse_output = model().reconstruction(2);
    model().set_acting(1, std::vector<std::uint8_t>(model().acting(1).size(), 1));
    const float dense = model().forward();
    EXPECT_NEAR(sparse, dense, 1e-6 * static_cast<double>(dense));
    const std::vector<float> dense_codes = model().codes(1);
    const std::vector<float> dense_output = model().reconstruction(2);
    for (std::size_t i = 0; i < dense_codes.size(); ++i) {
        EXPECT_NEAR(sparse_codes[i], dense_codes[i], 1e-5) << i;
    }
    for (std::size_t i = 0; i < dense_output.size(); ++i) {
        EXPECT_NEAR(sparse_output[i], dense_output[i], 1e-6) << i;
    }
}

// The same with an output that is not zero where nothing acts.
TEST_P(Supports, AreExactWithAConstantOutput) {
    start_deflation(model(), std::span<const float>(problem_.features),
                    std::span<const int>(problem_.shapes));
    const std::span<float> bias = model().parameters().value(model().levels()[1].decoder_bias);
    for (std::size_t i = 0; i < bias.size(); ++i)
        bias[i] = 0.02F * static_cast<float>(i % 7) - 0.05F;
    pass();
    const float sparse = model().forward();
    const std::vector<float> sparse_output = model().reconstruction(2);
    model().set_acting(1, std::vector<std::uint8_t>(model().acting(1).size(), 1));
    const float dense = model().forward();
    EXPECT_NEAR(sparse, dense, 1e-6 * static_cast<double>(dense));
    const std::vector<float> dense_output = model().reconstruction(2);
    for (std::size_t i = 0; i < dense_output.size(); ++i) {
        EXPECT_NEAR(sparse_output[i], dense_output[i], 1e-6) << i;
    }
}

// Loss weights times a constant are the same problem: the same vertices act.
TEST_P(Supports, DoNotDependOnTheUnitOfTheLoss) {
    std::vector<std::vector<std::uint8_t>> acts;
    for (const double unit : {1.0, 64.0}) {
        problem_.config.loss.reconstruction = unit;
        model_ = problem_.make_model();
        start_deflation(model(), std::span<const float>(problem_.features),
                        std::span<const int>(problem_.shapes));
        model().set_acting(1, std::vector<std::uint8_t>(model().acting(1).size(), 1));
        pass();
        model().adapt_supports(unit, 1);
        acts.push_back(model().acting(1));
    }
    EXPECT_EQ(acts[0], acts[1]);
    EXPECT_GT(count(acts[0]), 0);
    EXPECT_LT(count(acts[0]), static_cast<std::int64_t>(acts[0].size()));
}

// A larger penalty admits no more vertices, and one that no gradient reaches admits none where it
// acts in full.
TEST_P(Supports, GrowOnlyAgainstThePenalty) {
    std::int64_t before = std::numeric_limits<std::int64_t>::max();
    for (const double penalty : {0.0, 1.0, 1e9}) {
        start_deflation(model(), std::span<const float>(problem_.features),
                        std::span<const int>(problem_.shapes));
        model().set_acting(1, std::vector<std::uint8_t>(model().acting(1).size(), 1));
        pass();
        model().adapt_supports(penalty, 1);
        EXPECT_LE(count(model().acting(1)), before) << penalty;
        before = count(model().acting(1));
    }
}

// Training decides anew who acts.
TEST_P(Supports, AreAdaptedByTraining) {
    Trainer trainer(model(), problem_.config.train, problem_.features, problem_.shapes);
    trainer.start();
    model().set_acting(1, std::vector<std::uint8_t>(model().acting(1).size(), 1));
    EXPECT_LT(trainer.run_epoch().touched, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Targets, Supports, testing::Values(LossTarget::sum, LossTarget::share),
                         [](const auto& target) {
                             return target.param == LossTarget::sum ? "sum" : "share";
                         });

// A component that stands still in most batches lives on.
TEST(SupportsInSmallBatches, KeepWhatMovesRarely) {
    SmallTraining problem(100, 3);
    const int vertices = problem.mesh.vertex_count();
    for (std::size_t m = 0; m < 100; ++m) {
        if (m % 50 == 7) continue;  // in two of a hundred shapes patch 2 moves
        for (std::size_t v = 0; v < static_cast<std::size_t>(vertices); ++v) {
            problem.features[(m * static_cast<std::size_t>(vertices) + v) * 9 + 2] = 0;
        }
    }
    problem.config.stacked.levels = {{3, 0.3, 1.0, {}}};
    problem.config.train.batch = 10;
    std::vector<double> errors;
    for (const bool supports : {false, true}) {
        problem.config.train.supports = supports;
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
        trainer.start();
        EpochReport report;
        for (int epoch = 0; epoch < 40; ++epoch) report = trainer.run_epoch();
        errors.push_back(report.terms[0]);
        const std::span<const float> weights =
            std::as_const(model->parameters()).value(model->levels()[0].weights);
        for (std::size_t k = 0; k < 3; ++k) {
            const auto component = weights.subspan(k * weights.size() / 3, weights.size() / 3);
            EXPECT_TRUE(std::ranges::any_of(component, [](float x) { return x != 0; })) << k;
        }
    }
    EXPECT_LE(errors[1], 1.01 * errors[0]);
}

}  // namespace
}  // namespace mscomp::nn
