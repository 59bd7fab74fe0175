// SPDX-License-Identifier: MIT
#include "mscomp/eval/component_statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

/// Vertices on a line, one after the other: |i - j| / (V - 1).
class LineDistances : public DistanceRows {
  public:
    explicit LineDistances(std::vector<int> place) : place_(std::move(place)) {
        for (const int from : place_) {
            for (const int to : place_) {
                rows_.push_back(std::abs(from - to) / static_cast<double>(place_.size() - 1));
            }
        }
    }
    int vertex_count() const override { return static_cast<int>(place_.size()); }
    std::span<const double> row(int vertex) override {
        return std::span<const double>(rows_).subspan(
            static_cast<std::size_t>(vertex) * place_.size(), place_.size());
    }

  private:
    std::vector<int> place_;
    std::vector<double> rows_;
};

const std::vector<int> kLine{0, 1, 2, 3, 4};

using Rows = std::vector<std::vector<float>>;

ComponentStatistics statistics_of(const Rows& rows, const std::vector<int>& centers,
                                  const std::vector<int>& place = kLine, double threshold = 0) {
    LineDistances distances(place);
    const std::vector<std::span<const float>> spans(rows.begin(), rows.end());
    return component_statistics(spans, centers, distances, threshold);
}

/// Five vertices on a line with two channels each.
const Rows kRows{{3, 4, 0, 0, 0, 0.1F, 0, 0, 0, 0},
                 {0, 0, 0, 0, 0, 2, 0, 0, -1, 0},
                 {-3, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
const std::vector<int> kCenters{0, 2, 0};

// Component 0 acts on vertices 0 and 2, component 1 on 2 and 4, component 2 on 0.
TEST(ComponentStatistics, ExtentsAgreeWithAnExampleByHand) {
    const ComponentStatistics all = statistics_of(kRows, kCenters);
    ASSERT_EQ(all.components.size(), 3u);
    EXPECT_EQ(all.components[0].support, 2);
    EXPECT_EQ(all.components[1].support, 2);
    EXPECT_EQ(all.components[2].support, 1);
    EXPECT_DOUBLE_EQ(all.components[0].support_share, 2 / 5.0);
    EXPECT_DOUBLE_EQ(all.support_mean, (2 + 2 + 1) / 15.0);
    EXPECT_DOUBLE_EQ(all.components[0].localization_radius, 2 / 4.0);
    EXPECT_DOUBLE_EQ(all.components[1].localization_radius, 2 / 4.0);
    EXPECT_DOUBLE_EQ(all.components[2].localization_radius, 0);
}

// The 0.1 of component 0 at vertex 2 is not above 0.2; vertex 0 has length 5, as far as it gets.
TEST(ComponentStatistics, ThresholdLimitsTheRadiusNotTheSupport) {
    const ComponentStatistics all = statistics_of(kRows, kCenters, kLine, 0.2);
    EXPECT_DOUBLE_EQ(all.components[0].localization_radius, 0);
    EXPECT_EQ(all.components[0].support, 2);
    EXPECT_DOUBLE_EQ(all.components[1].localization_radius, 2 / 4.0);
    EXPECT_DOUBLE_EQ(statistics_of(kRows, {4, 4, 4}, kLine, 4.9).components[0].localization_radius,
                     1);
    EXPECT_DOUBLE_EQ(statistics_of(kRows, {4, 4, 4}, kLine, 5.1).components[0].localization_radius,
                     0);
}

// |D_0|^2 = 25.01, |D_1|^2 = 5, |D_2|^2 = 9; products 0.2, -9, 0.
TEST(ComponentStatistics, CosinesAgreeWithAnExampleByHand) {
    const ComponentStatistics all = statistics_of(kRows, kCenters);
    const double first = 0.1 * 2 / std::sqrt(25.01 * 5), second = -9 / std::sqrt(25.01 * 9);
    const std::vector<double> wanted{1, first, second, first, 1, 0, second, 0, 1};
    ASSERT_EQ(all.cosine.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(all.cosine[i], wanted[i], 1e-8);
    EXPECT_NEAR(all.cosine_mean, (first - second + 0) / 3, 1e-8);
    EXPECT_NEAR(all.cosine_max, -second, 1e-8);
}

TEST(ComponentStatistics, DoNotDependOnTheSizeOfComponents) {
    Rows larger = kRows;
    for (float& x : larger[0]) x *= 8;
    for (float& x : larger[1]) x *= -0.25F;
    const ComponentStatistics before = statistics_of(kRows, kCenters);
    const ComponentStatistics after = statistics_of(larger, kCenters);
    EXPECT_NEAR(after.cosine_mean, before.cosine_mean, 1e-12);
    EXPECT_NEAR(after.cosine_max, before.cosine_max, 1e-12);
    EXPECT_NEAR(after.cosine[1], -before.cosine[1], 1e-12);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(after.components[k].support, before.components[k].support);
        EXPECT_EQ(after.components[k].localization_radius,
                  before.components[k].localization_radius);
    }
}

TEST(ComponentStatistics, DoNotDependOnTheNumbersOfVertices) {
    const std::vector<int> order{3, 0, 4, 1, 2};
    Rows rows(kRows.size(), std::vector<float>(10));
    std::vector<int> centers, place(5);
    for (std::size_t i = 0; i < 5; ++i) {
        const auto to = static_cast<std::size_t>(order[i]);
        place[to] = static_cast<int>(i);
        for (std::size_t k = 0; k < rows.size(); ++k) {
            for (std::size_t c = 0; c < 2; ++c) rows[k][2 * to + c] = kRows[k][2 * i + c];
        }
    }
    for (const int center : kCenters) centers.push_back(order[static_cast<std::size_t>(center)]);
    const ComponentStatistics before = statistics_of(kRows, kCenters);
    const ComponentStatistics after = statistics_of(rows, centers, place);
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(after.components[k].support, before.components[k].support);
        EXPECT_EQ(after.components[k].localization_radius,
                  before.components[k].localization_radius);
    }
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(after.cosine[i], before.cosine[i], 1e-12);
}

TEST(ComponentStatistics, TakeComponentsThatAreZeroOrNotFinite) {
    Rows rows = kRows;
    rows[1].assign(10, 0);
    const ComponentStatistics zero = statistics_of(rows, kCenters);
    EXPECT_EQ(zero.components[1].support, 0);
    EXPECT_EQ(zero.components[1].localization_radius, 0);
    EXPECT_EQ(zero.cosine[1], 0);
    EXPECT_EQ(zero.cosine[4], 1);
    EXPECT_TRUE(std::isfinite(zero.cosine_mean));

    rows[1][9] = std::numeric_limits<float>::quiet_NaN();
    const ComponentStatistics broken = statistics_of(rows, kCenters, kLine, 0.5);
    EXPECT_EQ(broken.components[1].support, 1);
    EXPECT_DOUBLE_EQ(broken.components[1].localization_radius, 2 / 4.0);
    EXPECT_TRUE(std::isnan(broken.cosine[4]));
    EXPECT_TRUE(std::isnan(broken.cosine_mean));
    EXPECT_TRUE(std::isnan(broken.cosine_max));
    // Also where the pairs that follow are numbers.
    rows[1] = kRows[1];
    rows[0][1] = rows[2][0] * std::numeric_limits<float>::infinity();
    const ComponentStatistics infinite = statistics_of(rows, kCenters);
    EXPECT_TRUE(std::isnan(infinite.cosine_max));
    EXPECT_TRUE(std::isnan(infinite.cosine[0]));
}

TEST(ComponentStatistics, OfOneOrNoComponentHaveNoOverlap) {
    const ComponentStatistics one = statistics_of({kRows[0]}, {0});
    EXPECT_EQ(one.cosine_mean, 0);
    EXPECT_EQ(one.cosine_max, 0);
    const ComponentStatistics none = statistics_of({}, {});
    EXPECT_TRUE(none.components.empty());
    EXPECT_EQ(none.support_mean, 0);
}

TEST(ComponentStatistics, RefuseWhatDoesNotFit) {
    EXPECT_THROW(statistics_of(kRows, {0, 2}), UsageError);
    EXPECT_THROW(statistics_of(kRows, {0, 2, 5}), UsageError);
    EXPECT_THROW(statistics_of(kRows, {0, 2, -1}), UsageError);
    EXPECT_THROW(statistics_of({kRows[0], {1, 2, 3, 4, 5}}, {0, 2}), UsageError);
    EXPECT_THROW(statistics_of({{1, 2, 3}}, {0}), UsageError);
    EXPECT_THROW(statistics_of({{}}, {0}), UsageError);
}

}  // namespace
}  // namespace mscomp
