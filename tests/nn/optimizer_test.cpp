// SPDX-License-Identifier: MIT
#include "nn/optimizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <type_traits>

#include "nn/resolution.h"
#include "op_table.h"
#include "small_spectral.h"
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

/// Rate scales of all parameters with an entry for each vertex, of a model of either class.
template <class Model, class Config>
std::map<std::string, double> rate_scales(const Config& config, int subdivisions) {
    const TriangleMesh mesh = shapes::icosphere(subdivisions);
    const OneRings rings = one_rings_of_faces(mesh.vertex_count(), mesh.faces);
    LineDistances line(2);
    typename Model::Options options;
    options.batch = 1;
    options.losses = false;
    const auto made = [&] {
        if constexpr (std::is_same_v<Model, SpectralVae<float>>) {
            return std::make_unique<Model>(config, SpectralLossConfig{}, rings,
                                           std::span<const double>{}, line, options);
        } else {
            return std::make_unique<Model>(config, LossConfig{}, rings, line, options);
        }
    }();
    std::map<std::string, double> scales;
    const ParameterSet<float>& parameters = made->parameters();
    for (int i = 0; i < parameters.count(); ++i) {
        const auto& entry = parameters.entry(i);
        if (entry.extents.size() == 4) scales[entry.name] = entry.rate_scale;
    }
    return scales;
}

// Components of unit length on a mesh four times as fine have entries half as long; above 10,000
// vertices the steps of their weights shrink as these do, below they are as they were. Codes may
// grow as the vertices do, but not the logarithms of their spread.
TEST(Adam, StepsOfComponentsShrinkOnFineMeshesInEveryKind) {
    using Scales = std::map<std::string, double>;
    StackedConfig stacked;
    stacked.levels = {{1, 0.3, {}, {}}, {1, 0.3, {}, {}}};
    SpectralConfig spectral;
    spectral.components = 1;
    const Scales coarse = rate_scales<StackedModel<float>>(stacked, 4);  // 2,562 vertices
    EXPECT_EQ(coarse, (Scales{{"level0.component_weights", 1}, {"level1.component_weights", 1}}));
    EXPECT_EQ(rate_scales<SpectralVae<float>>(spectral, 4),
              (Scales{{"component_weights", 1}, {"spread_weights", 1}}));
    const double fine = 10000.0 / 40962;
    for (const auto& [name, scale] : rate_scales<StackedModel<float>>(stacked, 6)) {
        EXPECT_NEAR(scale, std::sqrt(fine), 1e-12) << name;
    }
    const Scales vae = rate_scales<SpectralVae<float>>(spectral, 6);
    EXPECT_NEAR(vae.at("component_weights"), std::sqrt(fine), 1e-12);
    EXPECT_NEAR(vae.at("spread_weights"), fine, 1e-12);
}

// The same shapes on a mesh four times as fine: features repeat, errors are four times as large and
// codes twice. So is the limit, and the penalty four times as large, as the error is.
TEST(CodeLimits, PenaltyGrowsAsTheErrorDoes) {
    const auto penalty = [](double code, int vertices) {
        const CodeLimit limit = code_limit({}, 1, vertices);
        return limit.weight * std::max(code - limit.limit, 0.0);
    };
    EXPECT_EQ(code_limit({}, 1, 10000).limit, 5);
    EXPECT_EQ(code_limit({}, 1, 10000).weight, 1);
    EXPECT_EQ(code_limit({}, 0.5, 100).limit, 5);
    EXPECT_EQ(code_limit({}, 0.5, 100).weight, 0.5);
    for (const int vertices : {10000, 30000, 1000000}) {
        const double code = 7 * code_growth(vertices);
        EXPECT_NEAR(penalty(2 * code, 4 * vertices), 4 * penalty(code, vertices), 1e-9);
        EXPECT_GT(penalty(code, vertices), 0);
        EXPECT_EQ(penalty(0.7 * code, vertices), 0);
        // The papers' number is the same everywhere.
        EXPECT_EQ(code_limit(5.0, 0.5, vertices).limit, 5);
        EXPECT_EQ(code_limit(5.0, 0.5, vertices).weight, 0.5);
    }
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
