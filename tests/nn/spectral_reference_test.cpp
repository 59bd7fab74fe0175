// SPDX-License-Identifier: MIT
// The spectral VAE against an independent float64 program: loss terms, outputs, gradients, ten Adam
// steps.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "mscomp/base/safetensors.h"
#include "nn/optimizer.h"
#include "nn/spectral_vae.h"
#include "reference_case.h"

namespace mscomp::nn {
namespace {

SpectralConfig spectral_config(const nlohmann::json& from) {
    SpectralConfig config;
    config.components = from.at("K");
    config.filter_order = from.at("H");
    config.tied = from.at("tied") == "same" ? Tied::same : Tied::none;
    config.lambda_max = from.at("lambda_max").is_string() ? LambdaMax::exact : LambdaMax::two;
    config.spread = from.at("sigma") == "linear" ? Spread::linear : Spread::log_variance;
    config.spread_offset = 0;
    config.kl_epsilon = from.at("kl_eps");
    config.straight_through =
        from.at("ste") == "identity" ? StraightThrough::identity : StraightThrough::outside;
    config.range_term = from.at("phi") == "l2" ? RangeTerm::l2 : RangeTerm::sum;
    return config;
}

SpectralLossConfig loss_config(const nlohmann::json& from) {
    const nlohmann::json& weights = from.at("l");
    return {1.0,
            weights.at("KL"),
            weights.at("Omega"),
            weights.at("Pi"),
            weights.at("Phi"),
            from.at("theta").get<double>()};
}

/// A case, with small ops or fused.
class SpectralReferenceCase : public testing::TestWithParam<std::tuple<const char*, bool>> {
  protected:
    static bool fused() { return std::get<1>(GetParam()); }

    void SetUp() override {
        const std::string stem =
            std::string(MSCOMP_SHARED_DIR "/reference/") + std::get<0>(GetParam());
        if (!std::filesystem::exists(stem + ".json")) GTEST_SKIP() << stem << ".json is absent";
        settings_ = nlohmann::json::parse(std::ifstream(stem + ".json"));
        file_ = std::make_unique<SafetensorsFile>(stem + ".safetensors");
        shapes_ = settings_.at("N");
        distances_ = std::make_unique<StoredDistances>(data("geod"), settings_.at("V"));
        const auto offsets = file_->data<int>("adj_ptr", {-1});
        const auto neighbors = file_->data<int>("adj_idx", {-1});
        SpectralVae<double>::Options options;
        options.batch = shapes_;
        options.sparsity_gradient = true;
        options.fused = fused();
        options.input_gradient = !fused();
        model_ = std::make_unique<SpectralVae<double>>(
            spectral_config(settings_.at("config")), loss_config(settings_.at("config")),
            OneRings{{offsets.begin(), offsets.end()}, {neighbors.begin(), neighbors.end()}},
            std::span<const double>{}, *distances_, options);
        for (const auto& [index, name] : entries()) {
            model_->from_user_order(index, data("init/" + name), model_->parameters().value(index));
        }
        std::vector<int> all(static_cast<std::size_t>(shapes_));
        for (int i = 0; i < shapes_; ++i) all[static_cast<std::size_t>(i)] = i;
        model_->load_batch(data("X"), std::span<const int>(all));
        set_noise(0);
    }

    std::span<const double> data(const std::string& name) const {
        return file_->data<double>(name, file_->shape(name));
    }
    /// Every parameter and its name in the file.
    std::vector<std::pair<int, std::string>> entries() const {
        const auto& indices = model_->indices();
        std::vector<std::pair<int, std::string>> all{{indices.theta, "theta"},
                                                     {indices.weights, "C"},
                                                     {indices.spread_weights, "Cstd"},
                                                     {indices.ranges, "d"}};
        if (model_->config().own_decoder()) all.emplace_back(indices.decoder_theta, "theta_dec");
        return all;
    }
    void set_noise(int step) {
        const std::size_t size = static_cast<std::size_t>(shapes_ * model_->config().components);
        model_->set_noise(data("eps").subspan(static_cast<std::size_t>(step) * size, size));
    }
    void expect_close(const std::string& name, double got, double wanted) const {
        EXPECT_TRUE(std::abs(got - wanted) <= kTolerance * std::max(1.0, std::abs(wanted)))
            << name << ": " << got << " instead of " << wanted;
    }
    void expect_close(const std::string& name, std::span<const double> got) const {
        const double error = relative_error(got, data(name));
        EXPECT_TRUE(error <= kTolerance) << name << ": " << error;
    }

    nlohmann::json settings_;
    std::unique_ptr<SafetensorsFile> file_;
    std::unique_ptr<StoredDistances> distances_;
    std::unique_ptr<SpectralVae<double>> model_;
    int shapes_ = 0;
};

TEST_P(SpectralReferenceCase, LossTermsMatch) {
    expect_close("lambda_max", model_->laplacian().lambda_max(), settings_.at("lambda_max"));
    const double total = settings_.at("total_loss");
    EXPECT_TRUE(std::abs(model_->forward() - total) <= kTolerance * total);
    const SpectralTerms terms = model_->terms();
    const nlohmann::json& wanted = settings_.at("terms");
    expect_close("recon", terms.reconstruction, wanted.at("recon"));
    expect_close("KL", terms.kl, wanted.at("KL"));
    expect_close("Omega", terms.sparsity, wanted.at("Omega"));
    expect_close("Pi", terms.range, wanted.at("Pi"));
    expect_close("Phi", terms.sparsity_range, wanted.at("Phi"));
}

TEST_P(SpectralReferenceCase, OutputsMatch) {
    model_->forward();
    expect_close("out/mu", model_->codes());
    expect_close("out/sigma", model_->deviations());
    expect_close("out/Z", model_->sampled_codes());
    expect_close("out/Xh", model_->reconstruction());
    const auto centers = file_->data<std::int64_t>("out/centers", {-1});
    const std::vector<int> got = model_->centers();
    EXPECT_EQ(std::vector<std::int64_t>(got.begin(), got.end()),
              std::vector<std::int64_t>(centers.begin(), centers.end()));
}

TEST_P(SpectralReferenceCase, GradientsMatch) {
    model_->forward();
    model_->parameters().zero_grad();
    model_->backward();
    for (const auto& [index, name] : entries()) {
        expect_close("grad/" + name,
                     model_->to_user_order(index, model_->parameters().grad(index)));
    }
    if (!fused()) expect_close("gradX", model_->input_gradient());
}

TEST_P(SpectralReferenceCase, TenAdamStepsMatch) {
    const auto history = data("loss_history");
    for (int step = 1; step <= 10; ++step) {
        set_noise(step - 1);
        const double expected = history[static_cast<std::size_t>(step - 1)];
        EXPECT_TRUE(std::abs(model_->forward() - expected) <= kTolerance * expected) << step;
        model_->parameters().zero_grad();
        model_->backward();
        adam_step(model_->parameters(), 1e-3, step);
        model_->clamp_ranges();
    }
    EXPECT_TRUE(std::abs(model_->forward() - history[10]) <= kTolerance * history[10]);
    for (const auto& [index, name] : entries()) {
        expect_close("final/" + name,
                     model_->to_user_order(index, model_->parameters().value(index)));
    }
}

INSTANTIATE_TEST_SUITE_P(
    Golden, SpectralReferenceCase,
    testing::Combine(testing::Values("vae_default", "vae_literal", "vae_order4"), testing::Bool()),
    [](const auto& each) {
        return std::string(std::get<0>(each.param)) +
               (std::get<1>(each.param) ? "_fused" : "_small_ops");
    });

}  // namespace
}  // namespace mscomp::nn
