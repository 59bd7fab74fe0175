// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_scaler.h"

#include <gtest/gtest.h>

#include "acap_cases.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace cases;

/// The reference and `count` random shapes of five vertices; r within 2, S - I within 0.5.
FeatureSet random_set(int count) {
    FeatureSet set;
    set.reference.vertices.resize(5);
    Draws draws(1);
    for (int n = 0; n <= count; ++n) {
        set.names.push_back("shape_" + std::to_string(n));
        for (int k = 0; k < 5 * kFeatureDim; ++k) {
            const int channel = k % kFeatureDim;
            const double deviation = n == 0 ? 0 : (channel < kRotationDim ? 2 : 0.5) * draws.next();
            set.features.push_back(static_cast<float>(kReferenceFeature[at(channel)] + deviation));
        }
    }
    return set;
}

/// Shape by shape where the scale depends on the vertex.
std::vector<float> scaled(const FeatureSet& set, const FeatureScaler& scaler, int vertices = 0) {
    std::vector<float> features = set.features;
    const std::size_t row = vertices == 0 ? features.size() : at(vertices * kFeatureDim);
    for (std::size_t i = 0; i < features.size(); i += row) {
        scaler.scale(std::span(features).subspan(i, row));
    }
    return features;
}

/// Smallest and largest value of the r (group 0) or S (group 1) entries.
std::array<double, 2> range(const std::vector<float>& features, int group) {
    std::array<double, 2> result{1e30, -1e30};
    for (std::size_t k = 0; k < features.size(); ++k) {
        if ((k % kFeatureDim < kRotationDim ? 0 : 1) != group) continue;
        result = {std::min<double>(result[0], features[k]),
                  std::max<double>(result[1], features[k])};
    }
    return result;
}

const std::vector<int> kAll{0, 1, 2, 3, 4};

// One factor for all channels: the smaller one, so that nothing leaves the range; a zero range
// keeps its zero.
TEST(FeatureScaler, ASharedFactorIsTheSmallerOne) {
    const FeatureSet set = random_set(4);
    const FeatureRanges ranges(MemoryFeatures(set.features, set.vertex_count()), kAll);
    const auto separate = ranges.scaler(FeatureCenter::reference, FeatureScale::separate);
    const auto shared = ranges.scaler(FeatureCenter::reference, FeatureScale::shared);
    ASSERT_NE(separate.factor[0], separate.factor[3]);
    for (const double factor : shared.factor) {
        EXPECT_EQ(factor, std::min(separate.factor[0], separate.factor[3]));
    }
    EXPECT_EQ(shared.offset, separate.offset);
    FeatureSet only_turns = set;
    for (std::size_t k = 0; k < only_turns.features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        if (channel >= kRotationDim) only_turns.features[k] = kReferenceFeature[channel];
    }
    const auto turns = FeatureRanges(MemoryFeatures(only_turns.features, set.vertex_count()), kAll)
                           .scaler(FeatureCenter::reference, FeatureScale::shared);
    EXPECT_GT(turns.factor[0], 0);
    EXPECT_EQ(turns.factor[3], 0);
}

// With a metric the largest entry counts with the root of its vertex, and comes to 0.95.
TEST(FeatureScaler, AMetricIsAPartOfTheScale) {
    const FeatureSet set = random_set(4);
    const std::vector<float> roots{0.5F, 3, 1, 0.25F, 2};
    const FeatureRanges ranges(MemoryFeatures(set.features, set.vertex_count()), kAll, roots);
    const auto scaler = ranges.scaler(FeatureCenter::reference, FeatureScale::shared);
    EXPECT_EQ(scaler.roots, roots);
    const std::vector<float> features = scaled(set, scaler, 5);
    double largest = 0;
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim, v = k / kFeatureDim % 5;
        const double wanted =
            scaler.factor[channel] * roots[v] * (set.features[k] - kReferenceFeature[channel]);
        EXPECT_NEAR(features[k], wanted, 1e-6);
        largest = std::max<double>(largest, std::abs(features[k]));
    }
    EXPECT_NEAR(largest, 0.95, 1e-6);
    EXPECT_TRUE(ranges.scaler(FeatureCenter::minmax).roots.empty());
}

// What fewer than a thousandth of the weight do decides nothing; what more do, does.
TEST(FeatureScaler, ARobustScaleLeavesOutAFewVertices) {
    constexpr int kVertices = 4000;
    FeatureSet set;
    set.reference.vertices.resize(kVertices);
    for (int v = 0; v < kVertices; ++v) {
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            const double largest = v < 4 ? 100.0 : v < 8 ? 5.0 : 1.0;
            set.features.push_back(
                static_cast<float>(kReferenceFeature[c] + (c == 1 ? largest : 0)));
        }
    }
    const MemoryFeatures features(set.features, kVertices);
    const std::vector<int> only{0};
    const auto factor = [&](std::vector<float> roots) {
        const FeatureRanges ranges(features, only, std::move(roots));
        return ranges.scaler(FeatureCenter::reference, FeatureScale::robust).factor[1];
    };
    EXPECT_NEAR(factor({}), 0.95 / 5, 1e-9);  // four of 4,000 are a thousandth and no more
    std::vector<float> roots(kVertices, 1);
    for (std::size_t v = 0; v < 8; ++v) roots[v] = 0.1F;
    EXPECT_NEAR(factor(roots), 0.95, 1e-7);  // eight of them with a hundredth of the weight
    roots.assign(kVertices, 1);
    roots[0] = 1.1F;
    EXPECT_NEAR(factor(roots), 0.95 / 100, 1e-9);
}

TEST(FeatureScaler, ReferenceGoesToZeroAndTheLargestTo095) {
    const FeatureSet set = random_set(4);
    const auto scaler = FeatureScaler::fit(set, kAll, FeatureCenter::reference);
    const std::vector<float> features = scaled(set, scaler);
    for (int k = 0; k < 5 * kFeatureDim; ++k) EXPECT_EQ(features[at(k)], 0);
    for (const int group : {0, 1}) {
        const auto [low, high] = range(features, group);
        EXPECT_NEAR(std::max(-low, high), 0.95, 1e-6);
    }
    for (int k = 1; k < kRotationDim; ++k) EXPECT_EQ(scaler.factor[at(k)], scaler.factor[0]);
    for (int k = 4; k < kFeatureDim; ++k) EXPECT_EQ(scaler.factor[at(k)], scaler.factor[3]);
}

TEST(FeatureScaler, MinmaxFillsTheRange) {
    const FeatureSet set = random_set(4);
    const auto features = scaled(set, FeatureScaler::fit(set, kAll, FeatureCenter::minmax));
    for (const int group : {0, 1}) {
        const auto [low, high] = range(features, group);
        EXPECT_NEAR(low, -0.95, 1e-6);
        EXPECT_NEAR(high, 0.95, 1e-6);
    }
}

TEST(FeatureScaler, UnscaleUndoesScale) {
    const FeatureSet set = random_set(4);
    for (const FeatureCenter center : {FeatureCenter::reference, FeatureCenter::minmax}) {
        const auto scaler = FeatureScaler::fit(set, kAll, center);
        std::vector<float> features = scaled(set, scaler);
        scaler.unscale(features);
        for (std::size_t k = 0; k < features.size(); ++k) {
            EXPECT_NEAR(features[k], set.features[k], 1e-6);
        }
    }
}

// Only training shapes count, and what lies beyond their range is not clamped.
TEST(FeatureScaler, ShapesThatAreNotTrainedOnMayExceedTheRange) {
    FeatureSet set = random_set(2);
    const auto before = FeatureScaler::fit(set, std::vector<int>{0, 1}, FeatureCenter::reference);
    set.features[2 * 5 * kFeatureDim] = 40;
    const auto after = FeatureScaler::fit(set, std::vector<int>{0, 1}, FeatureCenter::reference);
    EXPECT_EQ(before.factor, after.factor);
    EXPECT_GT(scaled(set, after)[2 * 5 * kFeatureDim], 10);
}

TEST(FeatureScaler, ZeroRangeGivesZerosAndComesBack) {
    const FeatureSet set = random_set(0);
    const std::vector<int> only{0};
    const auto scaler = FeatureScaler::fit(set, only, FeatureCenter::reference);
    std::vector<float> features = scaled(set, scaler);
    for (const float value : features) EXPECT_EQ(value, 0);
    scaler.unscale(features);
    EXPECT_EQ(features, set.features);
    // In the min-max reading r has no range here, S has: 0 and 1 are its ends.
    const auto minmax = scaled(set, FeatureScaler::fit(set, only, FeatureCenter::minmax));
    EXPECT_EQ(minmax[0], 0);
    EXPECT_NEAR(minmax[3], 0.95, 1e-6);
    EXPECT_NEAR(minmax[4], -0.95, 1e-6);
}

TEST(FeatureScaler, NamesThePlaceOfTheExtremes) {
    FeatureSet set = random_set(3);
    const auto place = [](int shape, int vertex, int channel) {
        return at((shape * 5 + vertex) * kFeatureDim + channel);
    };
    set.features[place(1, 2, 1)] = -7;
    set.features[place(3, 4, 0)] = 8;
    set.features[place(2, 0, 5)] = -3;
    set.features[place(1, 1, 8)] = 9;
    const auto extremes =
        FeatureScaler::fit(set, std::vector<int>{1, 2, 3}, FeatureCenter::reference).extremes;
    ASSERT_EQ(extremes.size(), 4U);
    const auto expect = [](const FeatureExtreme& e, float value, int shape, int vertex,
                           int channel) {
        EXPECT_EQ(std::tuple(e.value, e.shape, e.vertex, e.channel),
                  std::tuple(value, shape, vertex, channel));
    };
    expect(extremes[0], -7, 1, 2, 1);
    expect(extremes[1], 8, 3, 4, 0);
    expect(extremes[2], -3, 2, 0, 5);
    expect(extremes[3], 9, 1, 1, 8);
}

TEST(FeatureScaler, RefusesNoShapesUnknownShapesAndNaN) {
    FeatureSet set = random_set(2);
    EXPECT_THROW(FeatureScaler::fit(set, {}, FeatureCenter::reference), UsageError);
    EXPECT_THROW(FeatureScaler::fit(set, std::vector<int>{3}, FeatureCenter::reference),
                 UsageError);
    set.features[50] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(FeatureScaler::fit(set, std::vector<int>{1}, FeatureCenter::reference),
                 NumericalError);
}

}  // namespace
}  // namespace mscomp
