// SPDX-License-Identifier: MIT
// How the spectral VAE learns ranges beside exact zeros.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/optimizer.h"
#include "nn/start.h"
#include "small_spectral.h"

namespace mscomp::nn {
namespace {

constexpr int kComponents = 4;

/// A VAE with random parameters after a pass and its gradients.
template <class T>
struct Passed {
    SmallTraining problem;
    std::unique_ptr<SpectralVae<T>> model;

    explicit Passed(int channels = 9) {
        SpectralConfig& config = problem.config.spectral;
        config.components = kComponents;
        config.conv_channels = channels;
        config.initial_range = 0.23;
        problem.config.spectral_loss.reconstruction = 0.7;
        model = make_vae<T>(problem);
        start_random(*model, 5);
        for (int k = 0; k < kComponents; ++k) {
            range(k) = static_cast<T>(0.23 + 0.11 * k);
        }
        model->load_batch(std::span<const float>(problem.features),
                          std::span<const int>(problem.shapes));
        pass();
    }
    void pass() {
        model->draw_noise(3, 1);
        model->parameters().zero_grad();
        model->forward();
        model->backward();
    }
    T& range(int k) {
        return model->parameters().value(model->indices().ranges)[static_cast<std::size_t>(k)];
    }
    std::vector<double> slopes() const {
        const std::span<const T> grad = model->parameters().grad(model->indices().ranges);
        return {grad.begin(), grad.end()};
    }
    /// What add_range_slopes adds to slopes of zero.
    std::vector<double> added() {
        std::ranges::fill(model->parameters().grad(model->indices().ranges), T{0});
        add_range_slopes(*model);
        return slopes();
    }
    /// -(1/(2 delta)) (sum_in h |C|^2/2 + sum_out |g|^2/(2 h)), written down in the order of the
    /// user.
    std::vector<double> naive() {
        const int index = model->indices().weights, vertices = model->vertex_count();
        const auto channels = static_cast<std::size_t>(problem.config.spectral.conv_channels);
        const auto& parameters = model->parameters();
        const std::vector<T> c = model->to_user_order(index, parameters.value(index));
        const std::vector<T> g =
            model->to_user_order(index, std::span<const T>(parameters.grad(index)));
        const std::vector<T> mu = model->codes(), sigma = model->deviations();
        const std::vector<int> centers = model->centers();
        std::vector<double> result;
        for (std::size_t k = 0; k < kComponents; ++k) {
            double squares = 0;
            for (std::size_t m = 0; m < problem.shapes.size(); ++m) {
                squares += std::pow(static_cast<double>(mu[m * kComponents + k]), 2) +
                           std::pow(static_cast<double>(sigma[m * kComponents + k]), 2);
            }
            const double h = 2 * problem.config.spectral_loss.reconstruction /
                             static_cast<double>(problem.shapes.size()) * squares;
            const auto d = static_cast<double>(range(static_cast<int>(k)));
            const double delta = d / 10;
            double inside = 0, outside = 0;
            for (int v = 0; v < vertices; ++v) {
                const double distance =
                    problem.distances.row(centers[k])[static_cast<std::size_t>(v)];
                const std::size_t first =
                    (k * static_cast<std::size_t>(vertices) + static_cast<std::size_t>(v)) *
                    channels;
                for (std::size_t i = first; i < first + channels; ++i) {
                    if (distance > d - delta && distance <= d) {
                        inside += h * std::pow(static_cast<double>(c[i]), 2) / 2;
                    }
                    if (distance > d && distance < d + delta) {
                        outside += std::pow(static_cast<double>(g[i]), 2) / (2 * h);
                    }
                }
            }
            result.push_back(-(inside + outside) / (2 * delta));
        }
        return result;
    }
};

TEST(RangeSlopes, AreTheirFormula) {
    for (const int channels : {9, 5}) {
        Passed<double> passed(channels);
        const std::vector<double> wanted = passed.naive(), got = passed.added();
        for (std::size_t k = 0; k < kComponents; ++k) {
            EXPECT_LT(wanted[k], 0);
            EXPECT_NEAR(got[k] / wanted[k], 1, 1e-10) << "component " << k;
        }
    }
}

TEST(RangeSlopes, AreTheirFormulaInFloat) {
    Passed<float> passed;
    const std::vector<double> wanted = passed.naive(), got = passed.added();
    for (std::size_t k = 0; k < kComponents; ++k) EXPECT_NEAR(got[k] / wanted[k], 1, 1e-5);
}

TEST(RangeSlopes, AreAddedToWhatIsThere) {
    Passed<double> passed;
    const std::vector<double> before = passed.slopes();
    add_range_slopes(*passed.model);
    const std::vector<double> both = passed.slopes(), added = passed.added();
    for (std::size_t k = 0; k < kComponents; ++k) {
        EXPECT_NE(before[k], 0);
        EXPECT_NEAR(both[k], before[k] + added[k], 1e-12 * std::abs(before[k]));
    }
}

// A shell inside that has weights, or one outside that wants some, pulls the range up alone; what
// lies elsewhere does nothing.
TEST(RangeSlopes, EitherShellPushesTheRangeOut) {
    for (const bool is_inside : {true, false}) {
        for (const bool is_in_shell : {true, false}) {
            Passed<double> passed;
            const int index = passed.model->indices().weights;
            const std::span<double> c = passed.model->parameters().value(index);
            const std::span<double> g = passed.model->parameters().grad(index);
            std::ranges::fill(c, 0.0);
            std::ranges::fill(g, 0.0);
            const std::size_t vertices = passed.problem.mesh.vertices.size();
            std::size_t found = 0;
            for (std::size_t v = 0; v < vertices; ++v) {
                const double beyond = passed.model->component_centers().distances(1)[v] - 0.34;
                const bool is_near = std::abs(beyond) < 0.034;
                if ((beyond <= 0) != is_inside || is_near != is_in_shell) continue;
                (is_inside ? c : g)[(vertices + v) * 9 + 4] = is_inside ? 0.5 : -0.5;
                ++found;
            }
            ASSERT_GT(found, 3U);
            const std::vector<double> added = passed.added();
            for (std::size_t k = 0; k < kComponents; ++k) {
                if (k == 1 && is_in_shell) {
                    EXPECT_LT(added[k], 0);
                } else {
                    EXPECT_EQ(added[k], 0);
                }
            }
        }
    }
}

// A component that no shape uses, or without a range, has no slope; nothing is divided by zero.
TEST(RangeSlopes, OfZeroCodesAreZero) {
    Passed<float> passed;
    const int index = passed.model->indices().weights;
    const std::span<float> c = passed.model->parameters().value(index);
    std::fill_n(c.begin(), c.size() / kComponents, 0.0F);
    passed.range(2) = 0;
    passed.pass();
    const std::vector<double> added = passed.added();
    EXPECT_EQ(added[0], 0) << "no codes";
    EXPECT_LT(added[1], 0);
    EXPECT_EQ(added[2], 0) << "no range";
    EXPECT_LT(added[3], 0);
}

// Nearly zero codes have almost no curvature. Whatever slope that gives, it stays one that Adam can
// square.
TEST(RangeSlopes, OfTinyCodesStayFinite) {
    for (const float scale : {1e-6F, 1e-12F, 1e-18F, 1e-25F}) {
        Passed<float> passed;
        const int index = passed.model->indices().weights;
        const std::span<float> c = passed.model->parameters().value(index);
        for (float& x : c.first(c.size() / kComponents)) x *= scale;
        passed.pass();
        add_range_slopes(*passed.model);
        adam_step(passed.model->parameters(), 1e-3, 1);
        const int ranges = passed.model->indices().ranges;
        for (const float x : passed.model->parameters().grad(ranges)) {
            EXPECT_TRUE(std::isfinite(x)) << scale;
        }
        for (const float x : passed.model->parameters().moment2(ranges)) {
            EXPECT_TRUE(std::isfinite(x)) << scale;
        }
    }
}

TEST(RangeSlopes, ThreadsDoNotChangeABit) {
    std::vector<std::vector<double>> results;
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        results.push_back(Passed<float>().added());
    }
    set_thread_count(0);
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
}

/// Three patches of radius 0.25 to be learned from a start that reaches 0.2 only.
struct LearningRanges {
    SmallTraining problem;
    std::unique_ptr<SpectralVae<float>> model;

    LearningRanges() {
        problem.config.spectral.components = 3;
        problem.config.spectral.initial_range = 0.2;
        problem.config.train.learning_rate = 5e-3;
        problem.config.train.epochs = 800;
        EXPECT_EQ(problem.config.spectral_loss.sparsity_range, 1);
        model = make_vae<float>(problem);
    }
    std::span<const float> ranges() const {
        return model->parameters().value(model->indices().ranges);
    }
    /// Without noise.
    double error() {
        model->load_batch(std::span<const float>(problem.features),
                          std::span<const int>(problem.shapes));
        model->forward();
        return model->terms().reconstruction;
    }
};

// What they are there for: Phi alone takes ranges to nothing, beside exact zeros; with the slopes
// they settle, and the error is that of components, not of none.
TEST(RangeSlopes, KeepRangesFromCollapsing) {
    set_thread_count(1);  // many tiny passes
    LearningRanges with;
    Trainer trainer(*with.model, with.problem.config.train, with.problem.features,
                    with.problem.shapes);
    trainer.start();
    std::vector<float> earlier;
    while (!trainer.is_over()) {
        trainer.run_epoch();
        if (trainer.state().epoch == 600)
            earlier.assign(with.ranges().begin(), with.ranges().end());
    }
    LearningRanges without;
    const TrainConfig& train = without.problem.config.train;
    const MemoryFeatures memory(without.problem.features, without.model->vertex_count());
    without.model->start(train, ScaledFeatures{memory}, without.problem.shapes);
    without.error();
    for (int step = 1; step <= train.epochs; ++step) {
        without.model->parameters().zero_grad();
        without.model->prepare_step(0, step);
        without.model->forward_and_backward();
        adam_step(without.model->parameters(), train.learning_rate, step);
        proximal_step(*without.model, without.problem.config.spectral_loss.sparsity,
                      train.learning_rate, step);
        without.model->clamp_ranges();
    }
    set_thread_count(0);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(without.ranges()[k], 0);
        EXPECT_GT(with.ranges()[k], 0.1F);
        EXPECT_LT(with.ranges()[k], 0.5F);
        EXPECT_NEAR(with.ranges()[k], earlier[k], 0.05) << "it settles";
    }
    const double error = with.error(), collapsed = without.error();
    EXPECT_TRUE(error < 0.2 * collapsed) << error << " instead of " << collapsed;
}

// Fixed ranges stay to the bit, whatever pulls at them.
TEST(LearnedRanges, CanBeFixed) {
    for (const SparsityStep step : {SparsityStep::proximal, SparsityStep::subgradient}) {
        for (const bool is_learned : {true, false}) {
            LearningRanges fixed;
            fixed.problem.config.train.sparsity_step = step;
            fixed.problem.config.spectral.learned_range = is_learned;
            fixed.model = make_vae<float>(fixed.problem);
            Trainer trainer(*fixed.model, fixed.problem.config.train, fixed.problem.features,
                            fixed.problem.shapes);
            trainer.start();
            for (int epoch = 0; epoch < 5; ++epoch) trainer.run_epoch();
            for (const float d : fixed.ranges()) EXPECT_EQ(d == 0.2F, !is_learned);
        }
    }
}

// Noise is drawn anew for every step, the same for the same step: also in a model that has just
// been made, as after a resume.
TEST(SpectralVaeSteps, DrawTheirNoiseFromSeedAndStep) {
    LearningRanges first, second;
    const auto sampled = [](LearningRanges& of, std::uint64_t seed, std::int64_t step) {
        of.model->load_batch(std::span<const float>(of.problem.features),
                             std::span<const int>(of.problem.shapes));
        static_cast<Model<float>&>(*of.model).prepare_step(seed, step);
        of.model->forward();
        return of.model->sampled_codes();
    };
    const std::vector<float> one = sampled(first, 1, 1);
    EXPECT_NE(sampled(first, 1, 2), one);
    EXPECT_NE(sampled(first, 2, 1), one);
    EXPECT_EQ(sampled(first, 1, 1), one);
    EXPECT_EQ(sampled(second, 1, 1), one);
}

}  // namespace
}  // namespace mscomp::nn
