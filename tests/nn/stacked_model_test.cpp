// SPDX-License-Identifier: MIT
#include "mscomp/nn/stacked_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "mscomp/base/random.h"
#include "op_table.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

struct DecoderReading {
    std::string name;
    Tied tied;
    Activation latent, decoder_fc;
    friend void PrintTo(const DecoderReading& reading, std::ostream* out) { *out << reading.name; }
};

class Decoding : public testing::TestWithParam<DecoderReading> {};

// Decoding the codes of a shape gives what the forward pass gave for that shape: level 0 alone, and
// summed over the autoencoders of level 1, each by parameters of its own.
TEST_P(Decoding, RepeatsTheForwardPass) {
    constexpr int kShapes = 3, kVertices = 20;
    ModelConfig config;
    config.tied = GetParam().tied;
    config.latent_activation = GetParam().latent;
    config.decoder_fc_activation = GetParam().decoder_fc;
    config.levels = {{3, 0.5, 1.0, {}}, {2, 0.3, 1.0, {}}};
    const TriangleMesh mesh = shapes::grid(5, 4);
    LineDistances line(kVertices);
    StackedModel<double> model(config, {}, one_rings_of_faces(kVertices, mesh.faces), line,
                               {kShapes});
    const CounterRandom random(3, 1);
    for (int i = 0; i < model.parameters().count(); ++i) {
        for (double& x : model.parameters().value(i)) {
            x = 0.3 * random.normal(
                          static_cast<std::uint64_t>(&x - model.parameters().all_values().data()));
        }
    }
    std::vector<double> features(std::size_t{kShapes} * kVertices * 9);
    for (std::size_t i = 0; i < features.size(); ++i) features[i] = 0.5 * random.normal(100000 + i);
    const std::vector<int> which{2, 0, 1};
    model.load_batch(std::span<const double>(features), std::span<const int>(which));
    model.forward();

    std::vector<double> sum(features.size(), 0.0);
    for (int level = 0; level < 2; ++level) {
        const int autoencoders = level == 0 ? 1 : 3, components = level == 0 ? 3 : 2;
        const std::vector<double> codes = model.codes(level);
        ASSERT_EQ(codes.size(), static_cast<std::size_t>(kShapes * autoencoders * components));
        for (int m = 0; m < kShapes; ++m) {
            for (int a = 0; a < autoencoders; ++a) {
                const auto code = std::span(codes).subspan(
                    static_cast<std::size_t>((m * autoencoders + a) * components),
                    static_cast<std::size_t>(components));
                const std::vector<double> decoded = model.decode(level, a, code);
                ASSERT_EQ(decoded.size(), std::size_t{kVertices} * 9);
                for (std::size_t i = 0; i < decoded.size(); ++i) {
                    sum[static_cast<std::size_t>(m) * decoded.size() + i] += decoded[i];
                }
            }
        }
        const std::vector<double> expected = model.reconstruction(level + 1);
        for (std::size_t i = 0; i < sum.size(); ++i) {
            EXPECT_TRUE(std::abs(sum[i] - expected[i]) <= 1e-12) << "level " << level << " " << i;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(
    Readings, Decoding,
    testing::Values(
        DecoderReading{"transpose", Tied::transpose, Activation::none, Activation::none},
        DecoderReading{"same", Tied::same, Activation::none, Activation::none},
        DecoderReading{"none", Tied::none, Activation::none, Activation::none},
        DecoderReading{"latent_tanh", Tied::transpose, Activation::tanh, Activation::none},
        DecoderReading{"decoder_fc_tanh", Tied::none, Activation::none, Activation::tanh}),
    [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace mscomp::nn
