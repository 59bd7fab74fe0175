// SPDX-License-Identifier: MIT
#include "nn/optimizer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "op_table.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

TEST(LearningRate, FallsInStairsToTheFloor) {
    TrainConfig config;
    config.learning_rate = 1e-3;
    EXPECT_DOUBLE_EQ(learning_rate_at(config, 1), 1e-3);
    EXPECT_DOUBLE_EQ(learning_rate_at(config, 4000), 1e-3);
    EXPECT_DOUBLE_EQ(learning_rate_at(config, 4001), 0.9e-3);
    EXPECT_DOUBLE_EQ(learning_rate_at(config, 8001), 0.81e-3);
    EXPECT_DOUBLE_EQ(learning_rate_at(config, 4000000), 1e-5);
    config.learning_rate = 1e-6;  // a floor above the rate does not raise it
    EXPECT_DOUBLE_EQ(learning_rate_at(config, 4000000), 1e-6);
}

// With a constant gradient both corrected moments are exact from the first step on, so that every
// update is rate * g / (|g| + epsilon).
TEST(Adam, FirstStepsAreTheRateAlongTheSign) {
    ParameterSet<double> parameters;
    const int index = parameters.add("p", {3});
    const std::array<double, 3> gradient{2.0, -0.5, 0.0};
    for (int step = 1; step <= 3; ++step) {
        std::copy(gradient.begin(), gradient.end(), parameters.grad(index).begin());
        adam_step(parameters, 0.1, step);
    }
    EXPECT_NEAR(parameters.value(index)[0], -0.3, 1e-8);
    EXPECT_NEAR(parameters.value(index)[1], 0.3, 1e-7);
    EXPECT_EQ(parameters.value(index)[2], 0.0);
}

// Each parameter has its own scale of the rate, whatever pieces the steps are cut into.
TEST(Adam, ScalesTheRateOfEachParameter) {
    ParameterSet<double> parameters;
    const int plain = parameters.add("plain", {40000}), slow = parameters.add("slow", {40000});
    parameters.set_rate_scale(slow, 0.25);
    for (const int index : {plain, slow}) {
        std::ranges::fill(parameters.grad(index), 3.0);
    }
    adam_step(parameters, 0.1, 1);
    for (std::size_t i = 0; i < 40000; ++i) {
        EXPECT_NEAR(parameters.value(plain)[i], -0.1, 1e-8) << i;
        EXPECT_NEAR(parameters.value(slow)[i], -0.025, 1e-8) << i;
    }
}

// Components of unit length on a mesh four times as fine have entries half as long; above 10,000
// vertices the steps of their weights shrink as these do, below they are as they were.
TEST(Adam, StepsOfComponentsShrinkOnFineMeshes) {
    const auto scale_at = [](int subdivisions) {
        const TriangleMesh mesh = shapes::icosphere(subdivisions);
        LineDistances line(2);
        StackedModel<float>::Options options;
        options.batch = 1;
        options.losses = false;
        StackedConfig config;
        config.levels = {{1, 0.3, {}, {}}};
        const StackedModel<float> model(
            config, {}, one_rings_of_faces(mesh.vertex_count(), mesh.faces), line, options);
        return model.parameters().entry(model.levels()[0].weights).rate_scale;
    };
    EXPECT_EQ(scale_at(4), 1.0);                                  // 2,562 vertices
    EXPECT_NEAR(scale_at(6), std::sqrt(10000.0 / 40962), 1e-12);  // 40,962
}

class ProximalStep : public testing::Test {
  protected:
    ProximalStep() : model_(problem_.make_model()) {
        weights_ = model_->levels()[0].weights;
        // Component 0: 1 at its centre, 0.5 in one channel everywhere else.
        std::span<float> c = model_->parameters().value(weights_);
        for (int v = 0; v < vertices_; ++v) at(c, v) = v == center_ ? 1.0F : 0.5F;
        for (float& v : model_->parameters().moment2(weights_)) v = 0.04F;
        model_->levels()[0].sparsity->set_centers({center_, center_, center_});
    }
    float& at(std::span<float> c, int v) { return c[static_cast<std::size_t>(v * 9)]; }
    double distance(int v) {
        return model_->inner_distances().row(center_)[static_cast<std::size_t>(v)];
    }

    SmallTraining problem_;
    std::unique_ptr<StackedModel<float>> model_;
    int weights_ = 0, center_ = 7, vertices_ = 162;
};

// Inside the range nothing changes; outside the norm falls by rate w / (K sqrt(v)): here the
// corrected v at step 1 is 0.04 / 0.001 = 40, and K = 3.
TEST_F(ProximalStep, ShrinksOutsideTheRangeOnly) {
    const double rate = 1e-3, weight = 1000;
    proximal_step(*model_, weight, rate, 1);
    const double shrunk = 0.5 - rate * weight / (3 * std::sqrt(40.0));
    for (int v = 0; v < vertices_; ++v) {
        const float got = at(model_->parameters().value(weights_), v);
        if (v == center_) {
            EXPECT_EQ(got, 1.0F);
        } else if (distance(v) < 0.3) {
            EXPECT_EQ(got, 0.5F);
        } else {
            EXPECT_NEAR(got, shrunk, 1e-6);
        }
    }
}

TEST_F(ProximalStep, LeavesExactZeros) {
    proximal_step(*model_, 1e6, 1e-3, 1);
    for (int v = 0; v < vertices_; ++v) {
        if (distance(v) < 0.3) continue;
        EXPECT_EQ(at(model_->parameters().value(weights_), v), 0.0F);
    }
}

// Without weight there is nothing to do.
TEST_F(ProximalStep, OfWeightZeroIsTheIdentity) {
    const std::vector<float> before = all_of(*model_);
    proximal_step(*model_, 0, 1e-3, 1);
    EXPECT_EQ(all_of(*model_), before);
}

}  // namespace
}  // namespace mscomp::nn
