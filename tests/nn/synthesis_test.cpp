// SPDX-License-Identifier: MIT
#include "mscomp/model/synthesis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "mscomp/base/error.h"
#include "network_files.h"
#include "small_training.h"
#include "two_components.h"

namespace mscomp::nn {
namespace {

class SynthesisByHand : public testing::Test {
  protected:
    std::vector<Component> components() {
        return extract_components(*hand_.network, hand_.codes, {}, hand_.line);
    }
    /// What weights (W_0, W_1) change.
    std::vector<float> change(double first, double second) {
        const auto all = components();
        const Synthesis synthesis(*hand_.network, all);
        return synthesis.change(
            synthesis.codes(std::vector<ComponentWeight>{{0, first}, {1, second}}));
    }

    TwoComponents hand_;
};

// [B] eq. 14 from the reference (0.1, 0.05) to the ends (2, 0).
TEST_F(SynthesisByHand, CodesMoveFromTheReferenceTowardsTheEnd) {
    const auto all = components();
    const Synthesis synthesis(*hand_.network, all);
    const auto codes = synthesis.codes(std::vector<ComponentWeight>{{0, 0.3}, {1, -2.0}});
    EXPECT_NEAR(codes[0], 0.1 + 0.3 * 1.9, 1e-6);
    EXPECT_NEAR(codes[1], 0.05 + 2.0 * 0.05, 1e-6);  // away from its end
    const auto one = synthesis.codes(std::vector<ComponentWeight>{{0, 1.1}});
    EXPECT_NEAR(one[0], 0.1 + 1.1 * 1.9, 1e-6);
    EXPECT_EQ(one[1], static_cast<float>(all[1].code_reference));
}

// tanh(C^T z) - tanh(C^T z_r), unscaled by 0.5.
TEST_F(SynthesisByHand, ChangeIsThatOfTheDecodedFeatures) {
    const auto moved = change(0.7, 0.0);
    const double z = 0.1 + 0.7 * 1.9;
    EXPECT_NEAR(moved[2 * 9 + 4], (std::tanh(z) - std::tanh(0.1)) / 0.5, 1e-6);
    EXPECT_NEAR(moved[0], (std::tanh(0.5 * z + 0.0125) - std::tanh(0.05 + 0.0125)) / 0.5, 1e-6);
}

TEST_F(SynthesisByHand, WeightZeroIsTheReferenceExactly) {
    EXPECT_EQ(change(0, 0), std::vector<float>(45, 0.0F));
}

// What an export shows, bit for bit.
TEST_F(SynthesisByHand, WeightOneIsTheEndExactly) {
    const auto all = components();
    EXPECT_EQ(change(1, 0), all[0].difference);
    EXPECT_EQ(change(0, 1), all[1].difference);
}

// Disjoint supports, of which each row is decoded by itself: every vertex moves as with its
// component alone.
TEST_F(SynthesisByHand, ComponentsOfDisjointSupportsAdd) {
    std::vector<float> weights(std::size_t{2} * 5 * 9, 0.0F);
    weights[4] = 0.5F;                // component 0: vertices 0
    weights[2 * 9 + 1] = 0.75F;       // and 2,
    weights[(5 + 3) * 9] = 1.5F;      // component 1: vertices 3
    weights[(5 + 4) * 9 + 7] = 1.0F;  // and 4
    hand_.set_weights(weights);
    hand_.codes.values = {-0.5F, 0.5F, 2.0F, 1.0F};
    const auto first = change(0.8, 0), second = change(0, -1.2), both = change(0.8, -1.2);
    for (std::size_t i = 0; i < both.size(); ++i) {
        EXPECT_TRUE(first[i] == 0 || second[i] == 0);
        EXPECT_EQ(both[i], first[i] + second[i]);
    }
    EXPECT_NE(both[4], 0.0F);
    EXPECT_NE(both[3 * 9], 0.0F);
}

// Every component of every level, those of children included.
TEST(Synthesis, OfTwoLevelsReachesTheEndOfEveryComponent) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    trainer.run_epoch();
    Network network(*model, around_reference(0.5));
    const auto components = extract_components(network, trainer.codes(), {}, problem.distances);
    ASSERT_EQ(components.size(), static_cast<std::size_t>(network.code_count()));
    const Synthesis synthesis(network, components);
    for (const Component& c : components) {
        const std::vector<ComponentWeight> end{{c.code, 1.0}};
        EXPECT_EQ(synthesis.change(synthesis.codes(end)), c.difference) << c.id;
    }
}

constexpr int kDraws = 20000;

/// Mean (K) and covariance (K,K) over many draws.
struct Moments {
    std::vector<double> mean, covariance;
};

Moments moments_of(const std::vector<std::vector<float>>& rows, double freedom) {
    const std::size_t k = rows.front().size();
    Moments moments{std::vector<double>(k, 0.0), std::vector<double>(k * k, 0.0)};
    for (const auto& row : rows) {
        for (std::size_t i = 0; i < k; ++i) {
            moments.mean[i] += static_cast<double>(row[i]) / static_cast<double>(rows.size());
        }
    }
    for (const auto& row : rows) {
        for (std::size_t i = 0; i < k * k; ++i) {
            moments.covariance[i] += (static_cast<double>(row[i / k]) - moments.mean[i / k]) *
                                     (static_cast<double>(row[i % k]) - moments.mean[i % k]) /
                                     freedom;
        }
    }
    return moments;
}

Moments drawn_moments(const CodeSampler& sampler) {
    std::vector<std::vector<float>> rows;
    for (int i = 0; i < kDraws; ++i) rows.push_back(sampler.draw(static_cast<std::uint64_t>(i)));
    return moments_of(rows, kDraws - 1.0);
}

/// Five standard errors: var(z_i z_j) <= 2 var_i var_j.
void expect_near(const Moments& drawn, const Moments& wanted) {
    const std::size_t k = wanted.mean.size();
    for (std::size_t i = 0; i < k; ++i) {
        const double deviation = std::sqrt(wanted.covariance[i * k + i]);
        EXPECT_NEAR(drawn.mean[i], wanted.mean[i], 5 * deviation / std::sqrt(kDraws)) << i;
        for (std::size_t j = 0; j < k; ++j) {
            const double both = deviation * std::sqrt(wanted.covariance[j * k + j]);
            EXPECT_NEAR(drawn.covariance[i * k + j], wanted.covariance[i * k + j],
                        5 * both * std::sqrt(2.0 / kDraws))
                << i << " " << j;
        }
    }
}

/// Five shapes with three codes, correlated: 0 with 1 and with 2.
const CodeTable kCodes{
    3,
    {1.0F, 2.0F, 10.0F, 3.0F, 3.5F, 14.0F, -1.0F, 0.5F, 7.0F, 2.0F, 2.0F, 11.0F, 0.0F, 4.0F, 9.0F}};
constexpr int kTrainingShapes = 5;

std::vector<std::vector<float>> training_rows() {
    std::vector<std::vector<float>> rows;
    for (int m = 0; m < kTrainingShapes; ++m) {
        rows.emplace_back(kCodes.shape(m).begin(), kCodes.shape(m).end());
    }
    return rows;
}

TEST(CodeSampler, FittedHasMeanAndCovarianceOfTheTrainingCodes) {
    expect_near(drawn_moments(CodeSampler(CodeDistribution::fitted, kCodes, 7)),
                moments_of(training_rows(), kTrainingShapes - 1.0));
}

// The same without covariances.
TEST(CodeSampler, IndependentHasMeanAndVariancesOnly) {
    Moments wanted = moments_of(training_rows(), kTrainingShapes - 1.0);
    for (std::size_t i = 0; i < 9; ++i) {
        if (i % 4 != 0) wanted.covariance[i] = 0;
    }
    expect_near(drawn_moments(CodeSampler(CodeDistribution::independent, kCodes, 7)), wanted);
}

TEST(CodeSampler, PriorHasMeanZeroAndVarianceOne) {
    expect_near(drawn_moments(CodeSampler(CodeDistribution::prior, kCodes, 7)),
                {{0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}});
}

// Two shapes: every draw lies on the line through both, and on both sides of each.
TEST(CodeSampler, OfFewerShapesThanCodesStaysInTheirSpan) {
    const CodeSampler sampler(CodeDistribution::fitted, {3, {1, 0, 3, 3, 4, 5}}, 1);
    int beyond = 0;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const auto z = sampler.draw(i);
        const double t = (z[0] - 1.0) / 2;
        EXPECT_NEAR(z[1], 4 * t, 1e-5);
        EXPECT_NEAR(z[2], 3 + 2 * t, 1e-5);
        beyond += t < 0 || t > 1 ? 1 : 0;
    }
    // t is normal around 1/2 with variance 1/2: beyond with probability 0.48.
    EXPECT_NEAR(beyond, 96, 36);
}

TEST(CodeSampler, SameSeedGivesTheSameBitsWhateverTheOrder) {
    const CodeSampler a(CodeDistribution::fitted, kCodes, 3);
    const CodeSampler b(CodeDistribution::fitted, kCodes, 3);
    const CodeSampler other(CodeDistribution::fitted, kCodes, 4);
    const auto fifth = b.draw(5);
    EXPECT_EQ(a.draw(4), b.draw(4));
    EXPECT_EQ(a.draw(5), fifth);
    EXPECT_NE(a.draw(5), a.draw(4));
    EXPECT_NE(a.draw(5), other.draw(5));
}

TEST(CodeSampler, OneShapeHasNoGaussian) {
    EXPECT_THROW(CodeSampler(CodeDistribution::fitted, {3, {1, 2, 3}}, 0), UsageError);
    EXPECT_THROW(CodeSampler(CodeDistribution::independent, {3, {1, 2, 3}}, 0), UsageError);
    EXPECT_EQ(CodeSampler(CodeDistribution::prior, {3, {1, 2, 3}}, 0).draw(0).size(), 3U);
}

}  // namespace
}  // namespace mscomp::nn
