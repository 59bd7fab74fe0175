// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "nn/network.h"
#include "nn/stacked_model.h"
#include "op_table.h"

namespace mscomp::nn {

/// A network whose reference is encoded as what it is told.
class HandNetwork final : public Network {
  public:
    HandNetwork(Model<float>& model, const MetricScale& scale, std::vector<float> reference)
        : Network(model, scale), reference_(std::move(reference)) {}

    std::vector<float> reference_codes() override {
        const std::vector<int> first{0};
        model().load_batch(std::span<const float>(reference_), std::span<const int>(first));
        model().forward();
        return model().all_codes();
    }

  private:
    std::vector<float> reference_;  // (V,9) scaled
};

/// A line of five vertices 1/4 apart and two components that overlap at vertex 0. Convolutions are
/// the identity, so codes and features can be written down: z_k = sum C_k tanh(x), tanh(sum C_k
/// z_k). The reference is encoded as (0.1, 0.05).
struct TwoComponents {
    TwoComponents() {
        config.levels = {{2, 1.0, 1.0, {}}};
        model = std::make_unique<StackedModel<float>>(config, LossConfig{},
                                                      one_rings_of_faces(5, {{0, 1, 2}, {2, 3, 4}}),
                                                      line, StackedModel<float>::Options{});
        std::vector<float> weights(std::size_t{2} * 5 * 9, 0.0F);
        weights[0] = 0.5F;          // component 0: vertex 0, channel 0,
        weights[2 * 9 + 4] = 1.0F;  // vertex 2, channel 4, the longest,
        weights[3 * 9] = 0.004F;    // vertex 3, channel 0, hardly
        weights[5 * 9] = 0.25F;     // component 1: vertex 0, channel 0
        set_weights(weights);
        model->set_centers(0, {1, 0});  // inside the range of every vertex: they stay
        reference[0] = static_cast<float>(std::atanh(0.2));
        MetricScale scale;
        scale.factor.fill(0.5);
        network = std::make_unique<HandNetwork>(*model, scale, reference);
    }

    /// (2,5,9)
    void set_weights(const std::vector<float>& weights) {
        const auto& level = model->levels()[0];
        ParameterSet<float>& parameters = model->parameters();
        model->from_user_order(level.weights, weights, parameters.value(level.weights));
        for (std::size_t i = 0; i < 81; i += 10) parameters.value(level.w_own)[i] = 1;
        if (network) network->forget_decoder();
    }

    LineDistances line{5};
    StackedConfig config;
    std::unique_ptr<StackedModel<float>> model;
    std::vector<float> reference = std::vector<float>(45, 0.0F);
    std::unique_ptr<HandNetwork> network;
    CodeTable codes{2, {-0.5F, 0.0F, 2.0F, 0.0F}};  // two shapes
};

}  // namespace mscomp::nn
