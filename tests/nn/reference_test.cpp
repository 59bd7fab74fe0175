// SPDX-License-Identifier: MIT
// Whole models against an independent float64 program: loss terms, gradients, ten Adam steps.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "mscomp/base/safetensors.h"
#include "nn/optimizer.h"
#include "nn/stacked_model.h"
#include "reference_case.h"

namespace mscomp::nn {
namespace {

Activation activation(const std::string& name) {
    return name == "tanh" ? Activation::tanh : Activation::none;
}

StackedConfig model_config(const nlohmann::json& from) {
    StackedConfig config;
    config.attention = from.at("attention");
    config.joint = from.at("joint");
    config.tied = from.at("tied") == "transpose" ? Tied::transpose
                  : from.at("tied") == "same"    ? Tied::same
                                                 : Tied::none;
    config.latent_activation = activation(from.at("act_z"));
    config.decoder_fc_activation = activation(from.at("act_f"));
    config.mask_power = 1;
    config.mask_epsilon = from.at("mask_eps");
    config.levels.clear();
    for (const auto& level : from.at("levels")) {
        LevelConfig l;
        l.components = level.at("K");
        l.max_support = 1;
        if (level.contains("d")) l.sparsity_range = level.at("d");
        if (level.contains("ramp")) l.sparsity_ramp = {level.at("ramp")[0], level.at("ramp")[1]};
        config.levels.push_back(l);
    }
    return config;
}

class ReferenceCase : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        const std::string stem = std::string(MSCOMP_SHARED_DIR "/reference/") + GetParam();
        if (!std::filesystem::exists(stem + ".json")) GTEST_SKIP() << stem << ".json is absent";
        settings_ = nlohmann::json::parse(std::ifstream(stem + ".json"));
        file_ = std::make_unique<SafetensorsFile>(stem + ".safetensors");
        vertices_ = settings_.at("V");
        const auto offsets = file_->data<int>("adj_ptr", {-1});
        const auto neighbors = file_->data<int>("adj_idx", {-1});
        distances_ =
            std::make_unique<StoredDistances>(file_->data<double>("geod", {-1, -1}), vertices_);
        const nlohmann::json& config = settings_.at("config");
        loss_ = {config.at("lambda")[0], config.at("lambda")[1], config.at("lambda")[2],
                 config.at("theta").get<double>(), LossTarget::share};
        const int shapes = settings_.at("N");
        model_ = std::make_unique<StackedModel<double>>(
            model_config(config), loss_,
            OneRings{{offsets.begin(), offsets.end()}, {neighbors.begin(), neighbors.end()}},
            *distances_, StackedModel<double>::Options{shapes, true, true});
        for_each_slice([&](int index, int a, const std::string& name) {
            const auto from = file_->data<double>("init/" + name, shape_of("init/" + name));
            const std::vector<double> inner = inner_slice(index, from);
            std::copy(inner.begin(), inner.end(),
                      model_->parameters().value(index).begin() +
                          static_cast<std::ptrdiff_t>(a * inner.size()));
        });
        std::vector<int> all(static_cast<std::size_t>(shapes));
        for (int i = 0; i < shapes; ++i) all[static_cast<std::size_t>(i)] = i;
        model_->load_batch(file_->data<double>("X", {-1, -1, -1}), all);
    }

    Shape shape_of(const std::string& name) const { return file_->shape(name); }

    /// Calls visit(parameter, autoencoder, "l0/0/Wp") for everything the file holds.
    template <class Visit>
    void for_each_slice(Visit visit) {
        for (std::size_t l = 0; l < model_->levels().size(); ++l) {
            const auto& level = model_->levels()[l];
            const bool own = model_->config().tied == Tied::none;
            const std::array<std::pair<int, const char*>, 7> entries{
                {{level.w_own, "Wp"},
                 {level.w_ring, "Wn"},
                 {level.bias, "b"},
                 {level.weights, "C"},
                 {level.decoder_bias, "b_dec"},
                 {own ? level.decoder_w_own : -1, "Wp_dec"},
                 {own ? level.decoder_w_ring : -1, "Wn_dec"}}};
            for (int a = 0; a < level.autoencoders; ++a) {
                for (const auto& [index, what] : entries) {
                    if (index < 0) continue;
                    visit(index, a, "l" + std::to_string(l) + "/" + std::to_string(a) + "/" + what);
                }
            }
        }
    }

    /// One autoencoder's part of a parameter between the user's and the inner vertex order.
    std::vector<double> inner_slice(int index, std::span<const double> user) const {
        std::vector<double> inner(user.begin(), user.end());
        if (model_->parameters().entry(index).extents.size() == 4) permute(user, inner, false);
        return inner;
    }
    std::vector<double> user_slice(int index, int a, std::span<const double> all) const {
        const auto& entry = model_->parameters().entry(index);
        const auto size = static_cast<std::size_t>(entry.count / entry.extents[0]);
        const std::span<const double> inner = all.subspan(static_cast<std::size_t>(a) * size, size);
        std::vector<double> user(inner.begin(), inner.end());
        if (entry.extents.size() == 4) permute(inner, user, true);
        return user;
    }
    void permute(std::span<const double> from, std::vector<double>& to, bool to_user) const {
        const std::size_t v_count = static_cast<std::size_t>(vertices_);
        for (std::size_t row = 0; row < from.size() / (v_count * 9); ++row) {
            for (std::size_t v = 0; v < v_count; ++v) {
                const auto user = static_cast<std::size_t>(model_->order().to_user[v]);
                const std::size_t source = row * v_count + (to_user ? v : user);
                const std::size_t target = row * v_count + (to_user ? user : v);
                for (std::size_t c = 0; c < 9; ++c) to[target * 9 + c] = from[source * 9 + c];
            }
        }
    }

    nlohmann::json settings_;
    std::unique_ptr<SafetensorsFile> file_;
    std::unique_ptr<StoredDistances> distances_;
    std::unique_ptr<StackedModel<double>> model_;
    LossConfig loss_;
    int vertices_ = 0;
};

TEST_P(ReferenceCase, LossTermsMatch) {
    const double total = model_->forward();
    const double expected = settings_.at("total_loss");
    EXPECT_TRUE(std::abs(total - expected) <= kTolerance * expected) << total;
    for (std::size_t l = 0; l < model_->levels().size(); ++l) {
        for (int a = 0; a < model_->levels()[l].autoencoders; ++a) {
            const AutoencoderTerms terms = model_->terms(static_cast<int>(l), a);
            const std::string id = "_l" + std::to_string(l) + "_" + std::to_string(a);
            const auto expect = [&](const std::string& name, double got) {
                const double wanted = settings_.at("terms").at(name + id);
                EXPECT_TRUE(std::abs(got - wanted) <= kTolerance * std::max(1.0, wanted))
                    << name << id << ": " << got << " instead of " << wanted;
            };
            expect("recon", terms.reconstruction);
            expect("omega", terms.sparsity);
            expect("range", terms.range);
        }
    }
}

TEST_P(ReferenceCase, OutputsMatch) {
    model_->forward();
    const std::vector<double> all =
        model_->reconstruction(static_cast<int>(model_->levels().size()));
    EXPECT_TRUE(relative_error(all, file_->data<double>("out/Xrec", {-1, -1, -1})) <= kTolerance);
    const std::vector<double> codes = model_->codes(0);
    EXPECT_TRUE(relative_error(codes, file_->data<double>("out/Z_l0_0", {-1, -1})) <= kTolerance);
}

TEST_P(ReferenceCase, GradientsMatch) {
    model_->forward();
    model_->parameters().zero_grad();
    model_->backward();
    for_each_slice([&](int index, int a, const std::string& name) {
        const std::vector<double> got = user_slice(index, a, model_->parameters().grad(index));
        const double error =
            relative_error(got, file_->data<double>("grad/" + name, shape_of("grad/" + name)));
        EXPECT_TRUE(error <= kTolerance) << name << ": " << error;
    });
    EXPECT_TRUE(relative_error(model_->input_gradient(),
                               file_->data<double>("gradX", {-1, -1, -1})) <= kTolerance);
}

TEST_P(ReferenceCase, TenAdamStepsMatch) {
    const auto history = file_->data<double>("loss_history", {-1});
    for (int step = 1; step <= 10; ++step) {
        const double loss = model_->forward();
        const double expected = history[static_cast<std::size_t>(step - 1)];
        EXPECT_TRUE(std::abs(loss - expected) <= kTolerance * expected) << "step " << step;
        model_->parameters().zero_grad();
        model_->backward();
        adam_step(model_->parameters(), 1e-3, step);
    }
    EXPECT_TRUE(std::abs(model_->forward() - history[10]) <= kTolerance * history[10]);
    for_each_slice([&](int index, int a, const std::string& name) {
        const std::vector<double> got = user_slice(index, a, model_->parameters().value(index));
        const double error =
            relative_error(got, file_->data<double>("final/" + name, shape_of("final/" + name)));
        EXPECT_TRUE(error <= kTolerance) << name << ": " << error;
    });
}

INSTANTIATE_TEST_SUITE_P(Golden, ReferenceCase,
                         testing::Values("stacked_default", "stacked_three_levels",
                                         "stacked_separate", "stacked_no_attention",
                                         "stacked_literal", "stacked_tied_same",
                                         "autoencoder_ramp"),
                         [](const auto& each) { return std::string(each.param); });

}  // namespace
}  // namespace mscomp::nn
