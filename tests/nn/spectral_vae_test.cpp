// SPDX-License-Identifier: MIT
#include "nn/spectral_vae.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/optimizer.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

/// A VAE on a sphere of 162 vertices (two chunks of them) with random parameters and features.
template <class T>
struct SmallVae {
    TriangleMesh mesh = shapes::icosphere(2);
    SphereDistances distances{mesh.vertices};
    SpectralConfig config;
    SpectralLossConfig loss;
    typename SpectralVae<T>::Options options;
    std::vector<float> features;
    std::vector<int> shapes;
    std::unique_ptr<SpectralVae<T>> model;

    explicit SmallVae(bool fused, int shape_count = 19, const SpectralConfig& from = small_config())
        : config(from) {
        loss.kl = 0.5;
        loss.range_limit = 0.5;
        options.batch = shape_count;
        options.fused = fused;
        options.sparsity_gradient = true;
        const CounterRandom random(3, 0);
        features.resize(static_cast<std::size_t>(shape_count * mesh.vertex_count() * 9));
        for (std::size_t i = 0; i < features.size(); ++i) {
            features[i] = static_cast<float>(1.6 * random.uniform(i) - 0.8);
        }
        shapes.resize(static_cast<std::size_t>(shape_count));
        std::iota(shapes.begin(), shapes.end(), 0);
        make();
    }

    static SpectralConfig small_config() {
        SpectralConfig config;
        config.components = 11;
        config.spread_offset = -0.5;
        // On the sphere vertices lie at exactly 0.2, where float and double may see different
        // sides.
        config.initial_range = 0.23;
        return config;
    }

    void make() {
        model = std::make_unique<SpectralVae<T>>(
            config, loss, one_rings_of_faces(mesh.vertex_count(), mesh.faces),
            std::span<const double>{}, distances, options);
        ParameterSet<T>& parameters = model->parameters();
        for (int index = 0; index < parameters.count(); ++index) {
            if (index == model->indices().ranges) continue;
            const CounterRandom random(4, static_cast<std::uint64_t>(index));
            std::vector<T> user(parameters.value(index).size());
            for (std::size_t i = 0; i < user.size(); ++i) {
                user[i] = static_cast<T>(0.1 * random.normal(i));
            }
            model->from_user_order(index, user, parameters.value(index));
        }
        model->load_batch(std::span<const float>(features), std::span<const int>(shapes));
        model->draw_noise(7, 1);
    }

    /// Loss and terms, then all gradients in the order of the user.
    std::vector<T> loss_and_gradients() {
        std::vector<T> all{model->forward()};
        const SpectralTerms terms = model->terms();
        for (const double term :
             {terms.reconstruction, terms.kl, terms.sparsity, terms.range, terms.sparsity_range}) {
            all.push_back(static_cast<T>(term));
        }
        model->parameters().zero_grad();
        model->backward();
        for (int index = 0; index < model->parameters().count(); ++index) {
            const auto user = model->to_user_order(index, model->parameters().grad(index));
            all.insert(all.end(), user.begin(), user.end());
        }
        return all;
    }

    void step(std::int64_t number) {
        model->draw_noise(7, number);
        model->parameters().zero_grad();
        model->forward();
        model->backward();
        adam_step(model->parameters(), 1e-3, number);
        proximal_step(*model, loss.sparsity, 1e-3, number);
        model->clamp_ranges();
    }
};

template <class A, class B>
void expect_close(const std::vector<A>& got, const std::vector<B>& wanted, double tolerance) {
    ASSERT_EQ(got.size(), wanted.size());
    double scale = 0, worst = 0;
    std::size_t where = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
        scale = std::max(scale, std::abs(static_cast<double>(wanted[i])));
        const double error = std::abs(static_cast<double>(got[i]) - static_cast<double>(wanted[i]));
        if (!(error <= worst)) {  // a NaN stays
            worst = error;
            where = i;
        }
    }
    EXPECT_GT(scale, 0);
    EXPECT_TRUE(worst <= tolerance * scale)
        << where << ": " << got[where] << " instead of " << wanted[where];
}

std::vector<SpectralConfig> variants() {
    std::vector<SpectralConfig> all(5, SmallVae<double>::small_config());
    all[1].tied = Tied::none;
    all[1].spread = Spread::linear;
    all[1].lambda_max = LambdaMax::exact;
    all[4].tied = Tied::same;
    all[2].filter_order = 1;
    all[3].filter_order = 5;
    all[3].components = 50;
    return all;
}

TEST(FusedSpectralVae, AgreesWithTheSmallOpsInDouble) {
    for (const SpectralConfig& config : variants()) {
        for (const int shapes : {3, 19, 40}) {
            SmallVae<double> small(false, shapes, config), fused(true, shapes, config);
            ASSERT_NE(small.model->tape().ops().size(), fused.model->tape().ops().size());
            expect_close(fused.loss_and_gradients(), small.loss_and_gradients(), 1e-12);
            expect_close(fused.model->reconstruction(), small.model->reconstruction(), 1e-12);
        }
    }
}

// The gradients of a term are scaled by the largest number of all, the loss of about 1e4 terms; a
// sum of n terms of random signs collects sqrt(n) roundoffs of 6e-8, here of at most 9 x 162 x 40
// terms of the loss.
TEST(FusedSpectralVae, AgreesWithDoubleInFloatWithinRoundoff) {
    for (const SpectralConfig& config : variants()) {
        SmallVae<float> single(true, 40, config);
        SmallVae<double> twice(false, 40, config);
        expect_close(single.loss_and_gradients(), twice.loss_and_gradients(),
                     std::sqrt(9.0 * 162 * 40) * 6e-8);
    }
}

TEST(SpectralVae, ThreadsDoNotChangeABitOfLossAndGradients) {
    for (const bool fused : {false, true}) {
        std::vector<std::vector<float>> results;
        for (const int threads : {1, 2, 7}) {
            set_thread_count(threads);
            SmallVae<float> vae(fused);
            results.push_back(vae.loss_and_gradients());
            vae.options.sparsity_gradient = false;
            vae.make();
            for (int step = 1; step <= 3; ++step) vae.step(step);
            const std::span<float> values = vae.model->parameters().all_values();
            results.back().insert(results.back().end(), values.begin(), values.end());
        }
        set_thread_count(0);
        EXPECT_EQ(results[0], results[1]);
        EXPECT_EQ(results[0], results[2]);
    }
}

// Mirrored numbering: features and parameters are moved along, gradients come back moved.
TEST(SpectralVae, CommutesWithRenumberingTheVertices) {
    SmallVae<double> plain(true), renumbered(true);
    const int count = plain.mesh.vertex_count();
    const auto moved = [&](int v) { return count - 1 - v; };
    for (int v = 0; v < count; ++v) {
        const auto to = static_cast<std::size_t>(moved(v)), from = static_cast<std::size_t>(v);
        renumbered.mesh.vertices[to] = plain.mesh.vertices[from];
    }
    for (Face& face : renumbered.mesh.faces) {
        for (int& v : face) v = moved(v);
    }
    SphereDistances distances(renumbered.mesh.vertices);
    const auto move = [&](auto& values) {
        auto result = values;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const std::size_t row = i / 9, v = row % static_cast<std::size_t>(count);
            result[(row - v + static_cast<std::size_t>(moved(static_cast<int>(v)))) * 9 + i % 9] =
                values[i];
        }
        values = result;
    };
    move(renumbered.features);
    SpectralVae<double> other(renumbered.config, renumbered.loss,
                              one_rings_of_faces(count, renumbered.mesh.faces), {}, distances,
                              renumbered.options);
    const auto is_per_vertex = [&](int index) {
        return other.parameters().entry(index).extents.size() == 4;
    };
    for (int index = 0; index < other.parameters().count(); ++index) {
        auto user = plain.model->to_user_order(index, plain.model->parameters().value(index));
        if (is_per_vertex(index)) move(user);
        other.from_user_order(index, user, other.parameters().value(index));
    }
    other.load_batch(std::span<const float>(renumbered.features),
                     std::span<const int>(renumbered.shapes));
    other.draw_noise(7, 1);
    EXPECT_NEAR(other.forward() / plain.model->forward(), 1, 1e-13);
    other.parameters().zero_grad();
    plain.model->parameters().zero_grad();
    other.backward();
    plain.model->backward();
    for (int index = 0; index < other.parameters().count(); ++index) {
        auto wanted = plain.model->to_user_order(index, plain.model->parameters().grad(index));
        if (is_per_vertex(index)) move(wanted);
        expect_close(other.to_user_order(index, other.parameters().grad(index)), wanted, 1e-12);
    }
}

// A gradient of two edges' weights: with weights of 1 the model is that of the 0/1 adjacency.
TEST(SpectralVae, EqualEdgeWeightsAreTheAdjacency) {
    SmallVae<double> plain(true);
    const OneRings rings = one_rings_of_faces(plain.mesh.vertex_count(), plain.mesh.faces);
    const std::vector<double> threes(rings.neighbors.size(), 3.0);
    const SpectralVae<double> weighted({}, {}, rings, threes, plain.distances, {});
    const std::span<const double> got = weighted.laplacian().weights();
    const std::span<const double> wanted = plain.model->laplacian().weights();
    ASSERT_EQ(got.size(), wanted.size());
    for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], wanted[i], 1e-15);
}

// Edge weights are those of the user's numbering: (L~ x)_v for x = 1 at one vertex is the entry of
// the edge, -w / sqrt(d_v d_j).
TEST(SpectralVae, EdgeWeightsFollowTheirEdges) {
    SmallVae<double> small(true);
    const OneRings rings = one_rings_of_faces(small.mesh.vertex_count(), small.mesh.faces);
    std::vector<double> weights, degrees;
    for (int v = 0; v < rings.vertex_count(); ++v) {
        degrees.push_back(0);
        for (int at = rings.offsets[static_cast<std::size_t>(v)];
             at < rings.offsets[static_cast<std::size_t>(v) + 1]; ++at) {
            const int n = rings.neighbors[static_cast<std::size_t>(at)];
            weights.push_back(1 + (v + n) % 5 + (v * n) % 7);
            degrees.back() += weights.back();
        }
    }
    const SpectralVae<double> vae({}, {}, rings, weights, small.distances, {});
    const OneRings& inner = vae.laplacian().rings();
    for (std::size_t v = 0; v < degrees.size(); ++v) {
        const int user = vae.order().to_user[v];
        for (int at = inner.offsets[v]; at < inner.offsets[v + 1]; ++at) {
            const auto n = static_cast<std::size_t>(at);
            const int other = vae.order().to_user[static_cast<std::size_t>(inner.neighbors[n])];
            const double weight = 1 + (user + other) % 5 + (user * other) % 7;
            EXPECT_NEAR(vae.laplacian().weights()[n],
                        -weight / std::sqrt(degrees[static_cast<std::size_t>(user)] *
                                            degrees[static_cast<std::size_t>(other)]),
                        1e-14);
        }
    }
}

// Noise is a function of seed, step, shape and component: the batch a shape comes in is not one.
TEST(SpectralVae, NoiseOfAShapeDoesNotDependOnItsBatch) {
    SmallVae<double> vae(true);
    const auto noise = [&](std::vector<int> shapes, std::uint64_t seed, std::int64_t step) {
        vae.model->load_batch(std::span<const float>(vae.features), std::span<const int>(shapes));
        vae.model->draw_noise(seed, step);
        vae.model->forward();
        // z - mu = sigma noise
        std::vector<double> result = vae.model->sampled_codes();
        const std::vector<double> mu = vae.model->codes(), sigma = vae.model->deviations();
        for (std::size_t i = 0; i < result.size(); ++i) result[i] = (result[i] - mu[i]) / sigma[i];
        return result;
    };
    const std::vector<double> both = noise({4, 9}, 1, 2), alone = noise({9}, 1, 2);
    for (std::size_t k = 0; k < 11; ++k) EXPECT_NEAR(both[11 + k], alone[k], 1e-9);
    for (const auto& other : {noise({9}, 1, 3), noise({9}, 2, 2), noise({8}, 1, 2)}) {
        for (std::size_t k = 0; k < 11; ++k) EXPECT_GT(std::abs(other[k] - alone[k]), 1e-9);
    }
    for (std::size_t k = 1; k < 11; ++k) EXPECT_NE(alone[k], alone[0]);
}

// Without noise z is mu, for any number of channels; what it decodes to: code_decoder_test.cpp.
TEST(SpectralVae, WithoutNoiseTheSampleIsTheMean) {
    for (const int channels : {9, 5}) {
        SpectralConfig config = SmallVae<double>::small_config();
        config.conv_channels = channels;
        SmallVae<double> vae(true, 3, config);
        EXPECT_FALSE(vae.config.own_decoder());
        vae.model->forward();
        EXPECT_NE(vae.model->sampled_codes(), vae.model->codes());
        vae.model->load_batch(std::span<const float>(vae.features),
                              std::span<const int>(vae.shapes));
        vae.model->forward();
        EXPECT_EQ(vae.model->sampled_codes(), vae.model->codes());
    }
}

// A model without losses, as for encoding, asks for no distances and gives the same codes.
TEST(SpectralVae, EncodesWithoutLosses) {
    SmallVae<double> vae(true);
    vae.model->forward();
    const std::vector<double> codes = vae.model->codes(), all = vae.model->reconstruction();
    vae.options.losses = false;
    vae.make();
    vae.model->forward();
    EXPECT_EQ(vae.model->codes(), codes);
    EXPECT_EQ(vae.model->reconstruction(), all);
    EXPECT_TRUE(vae.model->centers().empty());
}

// The proximal step: |C| falls by rate w / (K sqrt(v)) outside the learned range of each component,
// here with v = 0.04 / 0.001 = 40 at step 1, and nothing changes inside.
TEST(SpectralProximalStep, ShrinksOutsideTheLearnedRangesOnly) {
    SmallVae<double> vae(true);
    SpectralVae<double>& model = *vae.model;
    const auto& indices = model.indices();
    const std::span<double> c = model.parameters().value(indices.weights);
    std::ranges::fill(c, 0.0);
    std::ranges::fill(model.parameters().moment2(indices.weights), 0.04);
    const int center = 7, vertices = model.vertex_count();
    for (int k = 0; k < 11; ++k) {
        model.parameters().value(indices.ranges)[static_cast<std::size_t>(k)] = 0.05 * k;
        for (int v = 0; v < vertices; ++v) {
            c[static_cast<std::size_t>((k * vertices + v) * 9 + 4)] = v == center ? 1.0 : -0.5;
        }
    }
    proximal_step(model, 1000, 1e-3, 1);
    const double shrunk = -(0.5 - 1e-3 * 1000 / (11 * std::sqrt(40.0)));
    const int user_center = model.order().to_user[center];
    for (int k = 0; k < 11; ++k) {
        EXPECT_EQ(model.centers()[static_cast<std::size_t>(k)], user_center);
        for (int v = 0; v < vertices; ++v) {
            const double got = c[static_cast<std::size_t>((k * vertices + v) * 9 + 4)];
            const int user = model.order().to_user[static_cast<std::size_t>(v)];
            const bool inside =
                vae.distances.row(user_center)[static_cast<std::size_t>(user)] <= 0.05 * k;
            if (v == center) {
                EXPECT_EQ(got, 1.0);
            } else {
                EXPECT_NEAR(got, inside ? -0.5 : shrunk, 1e-12);
            }
        }
    }
    proximal_step(model, 1e7, 1e-3, 1);
    EXPECT_EQ(c[static_cast<std::size_t>((center == 0 ? 1 : 0) * 9 + 4)], 0.0);
}

// Ranges stay in [0, 1] however long they are pushed.
TEST(SpectralVae, RangesAreClamped) {
    SmallVae<float> vae(true);
    const std::span<float> d = vae.model->parameters().value(vae.model->indices().ranges);
    d[0] = -0.5F;
    d[1] = 1.5F;
    d[2] = 0.25F;
    vae.model->clamp_ranges();
    EXPECT_EQ(d[0], 0);
    EXPECT_EQ(d[1], 1);
    EXPECT_EQ(d[2], 0.25F);
}

// Four shapes can be learned by heart, also through another number of channels.
TEST(SpectralVae, OverfitsFourShapes) {
    set_thread_count(1);  // many tiny passes
    for (const int channels : {9, 12}) {
        SpectralConfig config = SmallVae<float>::small_config();
        config.conv_channels = channels;
        SmallVae<float> vae(true, 4, config);
        vae.loss = {1, 0, 0, 0, 0, 5};
        vae.make();
        vae.model->load_batch(std::span<const float>(vae.features),
                              std::span<const int>(vae.shapes));  // without noise
        const float before = vae.model->forward();
        for (int step = 1; step <= 60; ++step) {
            vae.model->parameters().zero_grad();
            vae.model->backward();
            adam_step(vae.model->parameters(), 2e-2, step);
            vae.model->forward();
        }
        EXPECT_LT(vae.model->forward(), 0.05F * before) << channels;
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace mscomp::nn
