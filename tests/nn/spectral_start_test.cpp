// SPDX-License-Identifier: MIT
// What the spectral VAE begins with.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/random.h"
#include "nn/start.h"
#include "small_spectral.h"

namespace mscomp::nn {
namespace {

/// Squares summed up in double.
double square_sum(std::span<const float> values) {
    double sum = 0;
    for (const float x : values) sum += static_cast<double>(x) * static_cast<double>(x);
    return sum;
}

struct Started {
    SmallTraining problem;
    std::unique_ptr<SpectralVae<float>> model;

    explicit Started(int channels = 9, Tied tied = Tied::transpose, int components = 3) {
        // Patches reach 0.25; on the sphere vertices lie at exactly 0.2.
        problem.config.spectral.initial_range = 0.28;
        problem.config.spectral.components = components;
        problem.config.spectral.conv_channels = channels;
        problem.config.spectral.tied = tied;
    }
    void start() {
        model = make_vae<float>(problem);
        const MemoryFeatures memory(problem.features, problem.mesh.vertex_count());
        model->start(problem.config.train, ScaledFeatures{memory}, problem.shapes);
    }
    std::span<const float> value(int index) const { return model->parameters().value(index); }
    std::span<const float> row(int k) const {
        const auto size = static_cast<std::size_t>(model->vertex_count()) *
                          static_cast<std::size_t>(model->config().conv_channels);
        return value(model->indices().weights).subspan(static_cast<std::size_t>(k) * size, size);
    }
    /// Reconstruction error of the codes without noise.
    double error() {
        model->load_batch(std::span<const float>(problem.features),
                          std::span<const int>(problem.shapes));
        model->forward();
        return model->terms().reconstruction;
    }
    double energy() const {
        return square_sum(problem.features) / static_cast<double>(problem.shapes.size());
    }
};

// theta_0 is the identity as far as it goes and all other filters are zero, the decoder's too.
TEST(SpectralDeflationStart, FiltersAreTheIdentity) {
    for (const int channels : {5, 9, 12}) {
        for (const Tied tied : {Tied::transpose, Tied::none}) {
            Started started(channels, tied);
            started.start();
            const auto& indices = started.model->indices();
            const auto expect_identity = [&](int index, int rows, int columns) {
                const std::span<const float> theta = started.value(index);
                ASSERT_EQ(theta.size(), static_cast<std::size_t>(3 * rows * columns));
                for (int h = 0; h < 3; ++h) {
                    for (int r = 0; r < rows; ++r) {
                        for (int c = 0; c < columns; ++c) {
                            EXPECT_EQ(theta[static_cast<std::size_t>((h * rows + r) * columns + c)],
                                      h == 0 && r == c ? 1.0F : 0.0F);
                        }
                    }
                }
            };
            expect_identity(indices.theta, 9, channels);
            if (tied == Tied::none) expect_identity(indices.decoder_theta, channels, 9);
        }
    }
}

// Rows of unit length, zero beyond the initial range of their centre; no spread but its offset.
TEST(SpectralDeflationStart, GivesUnitRowsWithinTheInitialRange) {
    for (const int channels : {5, 9, 12}) {
        Started started(channels);
        started.start();
        const SpectralVae<float>& model = *started.model;
        for (const float x : started.value(model.indices().spread_weights)) EXPECT_EQ(x, 0.0F);
        for (const float d : started.value(model.indices().ranges)) EXPECT_EQ(d, 0.28F);
        const std::vector<int> centers = model.centers();
        ASSERT_EQ(centers.size(), 3U);
        for (int k = 0; k < 3; ++k) {
            const std::span<const float> row = started.row(k);
            EXPECT_NEAR(square_sum(row), 1, 1e-5) << channels << " channels, component " << k;
            const auto distance =
                started.problem.distances.row(centers[static_cast<std::size_t>(k)]);
            for (std::size_t i = 0; i < row.size(); ++i) {
                const int inner = static_cast<int>(i) / channels;
                const int user = model.order().to_user[static_cast<std::size_t>(inner)];
                if (distance[static_cast<std::size_t>(user)] > 0.28) {
                    EXPECT_EQ(row[i], 0.0F);
                }
                if (static_cast<int>(i) % channels >= 9) {
                    EXPECT_EQ(row[i], 0.0F);
                }
            }
        }
    }
}

// A model that has the first channels only takes apart what these hold: rows of unit length along
// them, however much more there is in the others.
TEST(SpectralDeflationStart, OfFewChannelsLooksAtNoOthers) {
    Started started(5);
    const CounterRandom random(8, 0);
    for (std::size_t i = 0; i < started.problem.features.size(); ++i) {
        if (i % 9 < 5) continue;
        started.problem.features[i] = static_cast<float>(random.normal(i));
    }
    Started plain(5);
    started.start();
    plain.start();
    EXPECT_EQ(started.model->centers(), plain.model->centers());
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(square_sum(started.row(k)), 1, 1e-5) << "component " << k;
        for (std::size_t i = 0; i < started.row(k).size(); ++i) {
            EXPECT_NEAR(started.row(k)[i], plain.row(k)[i], 1e-6);
        }
    }
}

// Three separate patches and three components: one each, so that little is left of the energy,
// which is in the first three channels. It says the same of every width and of a decoder of its
// own, which starts as the transpose.
TEST(SpectralDeflationStart, ExplainsMostOfTheEnergy) {
    double first = -1;
    for (const int channels : {5, 9, 12}) {
        for (const Tied tied : {Tied::transpose, Tied::none}) {
            Started started(channels, tied);
            started.start();
            for (int patch = 0; patch < 3; ++patch) {
                const auto distance = started.problem.distances.row(patch);
                EXPECT_TRUE(std::ranges::any_of(
                    started.model->centers(),
                    [&](int center) { return distance[static_cast<std::size_t>(center)] < 0.1; }))
                    << "patch " << patch;
            }
            const double error = started.error();
            EXPECT_TRUE(error < 0.1 * started.energy()) << error << " of " << started.energy();
            if (first < 0) first = error;
            EXPECT_NEAR(error / first, 1, 1e-4);
        }
    }
}

TEST(SpectralDeflationStart, DoesNotDependOnTheBatch) {
    Started whole;
    whole.start();
    for (const int batch : {1, 5}) {
        Started started;
        started.problem.config.train.batch = batch;
        started.start();
        ASSERT_EQ(started.model->batch_capacity(), batch);
        EXPECT_EQ(started.model->centers(), whole.model->centers());
        const auto got = started.model->parameters().all_values();
        const auto wanted = whole.model->parameters().all_values();
        ASSERT_EQ(got.size(), wanted.size());
        for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], wanted[i], 1e-5);
    }
}

// More components than there is to explain, and shapes that do not move at all: zeros, no NaN.
TEST(SpectralDeflationStart, OfShapesThatDoNotMoveIsFinite) {
    for (const bool moves : {true, false}) {
        Started started(9, Tied::transpose, 20);
        if (!moves) std::ranges::fill(started.problem.features, 0.0F);
        started.start();
        Trainer trainer(*started.model, started.problem.config.train, started.problem.features,
                        started.problem.shapes);
        trainer.start();
        if (!moves) {
            EXPECT_EQ(square_sum(started.value(started.model->indices().weights)), 0);
        }
        for (int epoch = 0; epoch < 3; ++epoch) {
            EXPECT_TRUE(std::isfinite(trainer.run_epoch().total));
        }
        for (const float x : started.model->parameters().all_values()) {
            ASSERT_TRUE(std::isfinite(x));
        }
    }
}

// Whatever was there before is forgotten.
TEST(SpectralDeflationStart, BeginsAnew) {
    Started once, twice;
    once.start();
    twice.start();
    start_random(*twice.model, 1);
    const MemoryFeatures memory(twice.problem.features, twice.problem.mesh.vertex_count());
    start_deflation(*twice.model, ScaledFeatures{memory}, twice.problem.shapes);
    EXPECT_TRUE(std::ranges::equal(twice.model->parameters().all_values(),
                                   once.model->parameters().all_values()));
    EXPECT_EQ(twice.model->centers(), once.model->centers());
}

// N(0, 0.02^2): mean and variance of n of them are within 5 deviations, 0.02 / sqrt(n) and
// sqrt(2/n) of the variance; ranges as configured, no centres yet; another seed, other numbers.
TEST(SpectralRandomStart, HasTheDeviationOfThePaper) {
    Started started(12, Tied::none, 20);
    started.problem.config.train.start = Start::random;
    started.problem.config.train.seed = 3;
    started.start();
    const auto& indices = started.model->indices();
    for (const int index :
         {indices.theta, indices.decoder_theta, indices.weights, indices.spread_weights}) {
        const std::span<const float> values = started.value(index);
        const double count = static_cast<double>(values.size());
        double sum = 0;
        for (const float x : values) sum += static_cast<double>(x);
        EXPECT_NEAR(sum / count, 0, 5 * 0.02 / std::sqrt(count));
        EXPECT_NEAR(square_sum(values) / count / 4e-4, 1, 5 * std::sqrt(2 / count));
    }
    for (const float d : started.value(indices.ranges)) EXPECT_EQ(d, 0.28F);
    EXPECT_TRUE(started.model->centers().empty());
    const auto values = started.model->parameters().all_values();
    const std::vector<float> before(values.begin(), values.end());
    start_random(*started.model, 3);
    EXPECT_TRUE(std::ranges::equal(values, before));
    start_random(*started.model, 4);
    EXPECT_FALSE(std::ranges::equal(values, before));
    EXPECT_FALSE(
        std::ranges::equal(started.value(indices.weights), started.value(indices.spread_weights)));
    EXPECT_TRUE(std::isfinite(started.error()));
}

/// The s that has the least reconstruction e^s + kl (e^s - s - 1) / 2, by golden sections.
double best_log_variance(double reconstruction, double kl) {
    const auto cost = [&](double s) {
        return reconstruction * std::exp(s) + kl * (std::exp(s) - s - 1) / 2;
    };
    double low = -40, high = 10;
    const double part = (std::sqrt(5.0) - 1) / 2;
    while (high - low > 1e-7) {
        const double a = high - part * (high - low), b = low + part * (high - low);
        if (cost(a) < cost(b)) {
            high = b;
        } else {
            low = a;
        }
    }
    return (low + high) / 2;
}

TEST(SpreadOffset, IsWhereNoiseCostsWhatItGains) {
    for (const auto& [reconstruction, kl] :
         {std::pair{1.0, 0.01}, {1.0, 1.0}, {0.25, 3.0}, {10.0, 1e-3}}) {
        SpectralConfig config;
        SpectralLossConfig loss;
        loss.reconstruction = reconstruction;
        loss.kl = kl;
        // The minimum of a parabola is known to the root of the roundoff of its cost.
        const double wanted = best_log_variance(reconstruction, kl);
        EXPECT_NEAR(spread_offset(config, loss), wanted, 1e-5);
        config.spread = Spread::linear;
        EXPECT_NEAR(spread_offset(config, loss), std::exp(wanted / 2), 1e-5);
        config.spread_offset = -0.75;
        EXPECT_EQ(spread_offset(config, loss), -0.75);
        config.spread_offset = 0;
        EXPECT_EQ(spread_offset(config, loss), 0);
    }
    SpectralLossConfig free;
    free.kl = 0;
    EXPECT_TRUE(std::isfinite(spread_offset({}, free))) << "divergence costs nothing";
}

// At the reference f is zero, whatever the weights: sigma is that of the offset.
TEST(SpreadOffset, IsTheDeviationAtTheReference) {
    for (const Spread spread : {Spread::log_variance, Spread::linear}) {
        for (const std::optional<double> offset :
             {std::optional<double>{}, std::optional<double>{0.5}}) {
            Started started;
            started.problem.config.train.start = Start::random;
            started.problem.config.spectral.spread = spread;
            started.problem.config.spectral.spread_offset = offset;
            std::ranges::fill(started.problem.features, 0.0F);
            started.start();
            started.error();
            const double s = spread_offset(started.problem.config.spectral,
                                           started.problem.config.spectral_loss);
            const double wanted = spread == Spread::log_variance ? std::exp(s / 2) : s;
            for (const float sigma : started.model->deviations()) {
                EXPECT_NEAR(static_cast<double>(sigma) / wanted, 1, 1e-6);
            }
        }
    }
}

}  // namespace
}  // namespace mscomp::nn
