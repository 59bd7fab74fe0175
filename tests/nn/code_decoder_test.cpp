// SPDX-License-Identifier: MIT
// The decoder of all codes, for every kind and reading, against the forward pass it belongs to.
#include "nn/code_decoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mscomp/base/random.h"
#include "nn/spectral_vae.h"
#include "nn/stacked_model.h"
#include "op_table.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

constexpr int kShapes = 3, kVertices = 20;

struct DecoderCase {
    std::string name;
    std::function<std::unique_ptr<Model<double>>(const OneRings&, DistanceRows&)> make;
    friend void PrintTo(const DecoderCase& c, std::ostream* out) { *out << c.name; }
};

DecoderCase stacked(std::string name, Tied tied, Activation latent, Activation decoder_fc) {
    return {std::move(name), [=](const OneRings& rings, DistanceRows& distances) {
                StackedConfig config;
                config.tied = tied;
                config.latent_activation = latent;
                config.decoder_fc_activation = decoder_fc;
                config.levels = {{3, 0.5, 1.0, {}}, {2, 0.3, 1.0, {}}};
                return std::make_unique<StackedModel<double>>(
                    config, LossConfig{}, rings, distances, StackedModel<double>::Options{kShapes});
            }};
}

DecoderCase spectral(std::string name, int channels, Tied tied) {
    return {std::move(name), [=](const OneRings& rings, DistanceRows& distances) {
                SpectralConfig config;
                config.components = 11;
                config.conv_channels = channels;
                config.tied = tied;
                return std::make_unique<SpectralVae<double>>(config, SpectralLossConfig{}, rings,
                                                             std::span<const double>{}, distances,
                                                             SpectralVae<double>::Options{kShapes});
            }};
}

class Decoding : public testing::TestWithParam<DecoderCase> {
  protected:
    Decoding()
        : model_(GetParam().make(one_rings_of_faces(kVertices, mesh_.faces), line_)),
          features_(std::size_t{kShapes} * kVertices * 9) {
        const CounterRandom random(3, 1);
        for (int i = 0; i < model_->parameters().count(); ++i) {
            for (double& x : model_->parameters().value(i)) {
                x = 0.3 * random.normal(static_cast<std::uint64_t>(
                              &x - model_->parameters().all_values().data()));
            }
        }
        for (std::size_t i = 0; i < features_.size(); ++i) {
            features_[i] = 0.5 * random.normal(100000 + i);
        }
        const std::vector<int> which{2, 0, 1};
        model_->load_batch(std::span<const double>(features_), std::span<const int>(which));
        model_->forward();
    }

    /// All codes of shape m of the batch, level by level.
    std::vector<float> codes(int m) {
        std::vector<float> all;
        const std::vector<LevelSize> levels = model_->level_sizes();
        for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
            const std::vector<double> of_level = model_->codes(l);
            const int width = levels[static_cast<std::size_t>(l)].codes();
            all.insert(all.end(), of_level.begin() + m * width, of_level.begin() + (m + 1) * width);
        }
        return all;
    }

    TriangleMesh mesh_ = shapes::grid(5, 4);
    LineDistances line_{kVertices};
    std::unique_ptr<Model<double>> model_;
    std::vector<double> features_;
};

// Decoding the codes of a shape gives what the forward pass gave for that shape, all levels
// together; float against double.
TEST_P(Decoding, RepeatsTheForwardPass) {
    const std::unique_ptr<CodeDecoder> decoder = model_->decoder();
    EXPECT_EQ(decoder->vertex_count(), kVertices);
    const std::vector<double> expected =
        model_->reconstruction(static_cast<int>(model_->level_sizes().size()));
    for (int m = 0; m < kShapes; ++m) {
        const std::vector<float> z = codes(m);
        ASSERT_EQ(decoder->code_count(), static_cast<int>(z.size()));
        const std::vector<float> decoded = decoder->decode(z);
        ASSERT_EQ(decoded.size(), std::size_t{kVertices} * 9);
        for (std::size_t i = 0; i < decoded.size(); ++i) {
            const double wanted = expected[static_cast<std::size_t>(m) * decoded.size() + i];
            EXPECT_TRUE(std::abs(static_cast<double>(decoded[i]) - wanted) <= 2e-5)
                << "shape " << m << " entry " << i;
        }
    }
}

// Slopes are those of decode(), by differences of four points; what float rounds off is divided by
// the step.
TEST_P(Decoding, SlopesAreThoseOfTheDecoder) {
    const std::unique_ptr<CodeDecoder> decoder = model_->decoder();
    const std::vector<float> z = codes(0);
    const std::vector<DecoderColumn> columns = decoder->derivatives(z);
    ASSERT_EQ(columns.size(), z.size());
    constexpr float kStep = 1.0F / 64;
    for (std::size_t k = 0; k < z.size(); ++k) {
        std::vector<double> slope(std::size_t{kVertices} * 9, 0.0);
        for (std::size_t n = 0; n < columns[k].vertices.size(); ++n) {
            if (n > 0) {
                EXPECT_LT(columns[k].vertices[n - 1], columns[k].vertices[n]);
            }
            for (std::size_t c = 0; c < 9; ++c) {
                slope[static_cast<std::size_t>(columns[k].vertices[n]) * 9 + c] =
                    static_cast<double>(columns[k].values[n * 9 + c]);
            }
        }
        const auto at = [&](float steps) {
            std::vector<float> moved = z;
            moved[k] += steps * kStep;
            return decoder->decode(moved);
        };
        const auto near = at(1), back = at(-1), far = at(2), far_back = at(-2);
        for (std::size_t i = 0; i < slope.size(); ++i) {
            const double first = static_cast<double>(near[i]) - static_cast<double>(back[i]);
            const double second = static_cast<double>(far[i]) - static_cast<double>(far_back[i]);
            const double difference = (8 * first - second) / (12 * static_cast<double>(kStep));
            EXPECT_TRUE(std::abs(slope[i] - difference) <= 1e-4) << "code " << k << " entry " << i;
        }
    }
}

// Zero outside the support and the rings that the convolution reaches: what makes it fast.
TEST_P(Decoding, ColumnsAreAsSparseAsComponents) {
    ParameterSet<double>& parameters = model_->parameters();
    const int entry = model_->component_weights(0);
    const std::int64_t width = parameters.entry(entry).extents[3];
    std::vector<double> weights =
        model_->to_user_order(entry, std::as_const(parameters).value(entry));
    for (std::int64_t i = 0; i < kVertices * width; ++i) {
        if (i / width != 7) weights[static_cast<std::size_t>(i)] = 0;
    }
    model_->from_user_order(entry, weights, parameters.value(entry));
    const std::vector<float> z = codes(0);
    const DecoderColumn column = model_->decoder()->derivatives(z)[0];
    const OneRings rings = one_rings_of_faces(kVertices, mesh_.faces);
    // At most two rings: a Chebyshev filter of order three, or one ring for the others.
    std::vector<int> reached{7};
    for (int ring = 0; ring < 2; ++ring) {
        const std::vector<int> before = reached;
        for (const int v : before) {
            for (int n = rings.offsets[static_cast<std::size_t>(v)];
                 n < rings.offsets[static_cast<std::size_t>(v) + 1]; ++n) {
                reached.push_back(rings.neighbors[static_cast<std::size_t>(n)]);
            }
        }
    }
    EXPECT_LT(column.vertices.size(), std::size_t{kVertices});
    EXPECT_FALSE(column.vertices.empty());
    for (const int v : column.vertices) EXPECT_TRUE(std::ranges::count(reached, v) > 0) << v;
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, Decoding,
    testing::Values(stacked("transpose", Tied::transpose, Activation::none, Activation::none),
                    stacked("same", Tied::same, Activation::none, Activation::none),
                    stacked("none", Tied::none, Activation::none, Activation::none),
                    stacked("latent_tanh", Tied::transpose, Activation::tanh, Activation::none),
                    stacked("decoder_fc_tanh", Tied::none, Activation::none, Activation::tanh),
                    spectral("spectral", 9, Tied::transpose),
                    spectral("spectral_same", 9, Tied::same),
                    spectral("spectral_own_decoder", 9, Tied::none),
                    spectral("spectral_five_channels", 5, Tied::same),
                    spectral("spectral_five_transposed", 5, Tied::transpose)),
    [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace mscomp::nn
