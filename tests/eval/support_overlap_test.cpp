// SPDX-License-Identifier: MIT
#include "mscomp/eval/support_overlap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "mscomp/eval/unit_matches.h"

namespace mscomp {
namespace {

// In parts of their largest: found (1, 0.5, 0.05, 0, 0.2), true (0, 1, 0.5, 0, 0.1).
//   supports at 0.1: {0, 1, 4} and {1, 2}, since 0.1 does not exceed 0.1 -> 1 of 4
//   soft: (0 + 0.5 + 0.05 + 0 + 0.1) / (1 + 1 + 0.5 + 0 + 0.2)
const std::vector<double> kFound{4, 2, 0.2, 0, 0.8};
const std::vector<double> kTrue{0, 1, 0.5, 0, 0.1};

TEST(SupportOverlap, AgreesWithAnExampleByHand) {
    const SupportOverlap overlap = support_overlap(kFound, kTrue);
    EXPECT_DOUBLE_EQ(overlap.iou, 1.0 / 4);
    EXPECT_NEAR(overlap.soft_iou, 0.65 / 2.7, 1e-15);
    EXPECT_EQ(support_of(kFound), (std::vector<char>{1, 1, 0, 0, 1}));
    EXPECT_DOUBLE_EQ(support_overlap(kFound, kTrue, 0.01).iou, 3.0 / 4);
}

TEST(SupportOverlap, IsOneOfTheSameAndDoesNotSeeSize) {
    std::vector<double> twice = kTrue;
    for (double& x : twice) x *= 2e9;
    EXPECT_EQ(support_overlap(twice, kTrue).iou, 1);
    EXPECT_NEAR(support_overlap(twice, kTrue).soft_iou, 1, 1e-15);
}

TEST(SupportOverlap, OfNothingOrWhatIsNotFiniteIsNone) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const std::vector<double>& bad : {std::vector<double>(5, 0.0),
                                           {0, 1, 1, 0, nan},
                                           {nan, 1, 1, 0, 0},
                                           {0, 1, 1, 0, std::numeric_limits<double>::infinity()}}) {
        for (const SupportOverlap& overlap :
             {support_overlap(bad, kTrue), support_overlap(kTrue, bad)}) {
            EXPECT_EQ(overlap.iou, 0) << testing::PrintToString(bad);
            EXPECT_EQ(overlap.soft_iou, 0) << testing::PrintToString(bad);
        }
        EXPECT_EQ(std::ranges::count(support_of(bad), 1), 0) << testing::PrintToString(bad);
    }
}

/// Ten vertices: a stretch at `stretched`, turned by `turn` where `is_turned`.
std::vector<float> change(int stretched, const std::array<float, 3>& turn, const char* is_turned) {
    std::vector<float> rows(10 * kFeatureDim);
    for (std::size_t v = 0; v < 10; ++v) {
        if (is_turned[v] == '1') std::ranges::copy(turn, rows.begin() + 9 * static_cast<int>(v));
    }
    if (stretched >= 0) rows[9 * at(stretched) + 3] = 2;
    return rows;
}

TEST(ChangeLengths, AreThoseOfAllChannelsWhereNothingRests) {
    const std::vector<double> lengths =
        change_lengths(change(1, {1, 2, -2}, "0110000000"), std::vector<char>(10, 0));
    EXPECT_DOUBLE_EQ(lengths[0], 0);
    EXPECT_DOUBLE_EQ(lengths[1], std::sqrt(13.0));
    EXPECT_DOUBLE_EQ(lengths[2], 3);
}

// An elbow: the arm lies still and the forearm turns, or the other way round. It is the same bend.
TEST(ChangeLengths, DoNotDependOnWhichSideOfAJointLiesStill) {
    const std::vector<char> rests{1, 1, 1, 1, 1, 1, 0, 0, 0, 0};
    const auto forearm = change_lengths(change(7, {0, 1, 0}, "0000001111"), rests);
    const auto arm = change_lengths(change(7, {0, -1, 0}, "1111110000"), rests);
    EXPECT_EQ(forearm, arm);
    EXPECT_EQ(forearm[0], 0);
    EXPECT_EQ(forearm[9], 1);
}

// A bulge within the part that rests stays one: few vertices do not say how the others lie.
TEST(ChangeLengths, OfWhatMovesLittleOfTheRestAreUnchanged) {
    const std::vector<char> rests{1, 1, 1, 1, 1, 1, 1, 1, 0, 0};
    const auto lengths = change_lengths(change(-1, {3, 0, 4}, "0000011100"), rests);
    EXPECT_EQ(lengths, (std::vector<double>{0, 0, 0, 0, 0, 5, 5, 5, 0, 0}));
}

// Stretch is never taken off: where everything grows, nothing rests.
TEST(ChangeLengths, KeepStretchesOfTheRest) {
    std::vector<float> rows(10 * kFeatureDim, 0);
    for (std::size_t v = 0; v < 10; ++v) rows[9 * v + 3] = 1;
    EXPECT_EQ(change_lengths(rows, std::vector<char>(10, 1)), std::vector<double>(10, 1));
}

TEST(GreedyPairs, TakeTheLargestThenTheNext) {
    // Column 0 has its largest entry in row 0, which column 1 takes first.
    EXPECT_EQ(greedy_pairs(std::vector<double>{0.8, 0.9, 0.1, 0.2, 0.3, 0.4}, 3, 2),
              (std::vector<int>{2, 0}));
    EXPECT_EQ(greedy_pairs(std::vector<double>{0.5, 0.5}, 1, 2), (std::vector<int>{0, -1}));
    EXPECT_EQ(greedy_pairs({}, 0, 2), (std::vector<int>{-1, -1}));
}

// Three parts of a line of 30 vertices, found in another order, one twice, beside noise.
class FoundParts : public testing::Test {
  protected:
    static constexpr int kVertices = 30;
    FoundParts() {
        for (int part = 0; part < 3; ++part) {
            for (int v = 0; v < kVertices; ++v) supports_.push_back(v / 10 == part ? 1.0F : 0.0F);
        }
        add(2, 9, 1);
        add(0, 3, 2);
        add(0, 10, 3);
        add(1, 8, 4);
    }
    /// Acts on the first `count` vertices of a part.
    void add(int part, int count, std::uint64_t stream) {
        const CounterRandom random(1, stream);
        std::vector<float>& row = changes_.emplace_back(kVertices * kFeatureDim);
        for (int i = 0; i < count * kFeatureDim; ++i) {
            row[at(part * 10 * kFeatureDim + i)] =
                static_cast<float>(1 + 0.1 * random.uniform(at(i)));
        }
    }
    SupportMatches matches() const {
        const std::vector<std::span<const float>> rows(changes_.begin(), changes_.end());
        return support_matches(rows, supports_, kVertices);
    }

    std::vector<float> supports_;
    std::vector<std::vector<float>> changes_;
};

TEST_F(FoundParts, AreThoseThatLieThere) {
    const SupportMatches found = matches();
    EXPECT_EQ(found.one_to_one, (std::vector<int>{2, 3, 0}));
    EXPECT_DOUBLE_EQ(found.at(2, 0).iou, 1);
    EXPECT_DOUBLE_EQ(found.at(3, 1).iou, 0.8);
    EXPECT_DOUBLE_EQ(found.at(0, 2).iou, 0.9);
    EXPECT_DOUBLE_EQ(found.at(1, 0).iou, 0.3);
    EXPECT_EQ(found.at(0, 0).iou, 0);
}

TEST_F(FoundParts, AreTheSameForAnyNumberOfThreads) {
    std::vector<double> all[2];
    for (const int threads : {1, 7}) {
        set_thread_count(threads);
        for (const SupportOverlap& overlap : matches().overlaps) {
            all[threads / 7].push_back(overlap.iou);
            all[threads / 7].push_back(overlap.soft_iou);
        }
    }
    set_thread_count(0);
    EXPECT_EQ(all[0], all[1]);
}

TEST_F(FoundParts, LeaveTruthsWithoutAComponent) {
    changes_.resize(1);
    EXPECT_EQ(matches().one_to_one, (std::vector<int>{-1, -1, 0}));
    changes_.clear();
    EXPECT_EQ(matches().one_to_one, (std::vector<int>{-1, -1, -1}));
}

TEST(SupportMatches, RefuseWhatDoesNotFit) {
    const std::vector<float> row(27);
    const std::vector<std::span<const float>> changes{row};
    EXPECT_THROW(support_matches(changes, std::vector<float>(4), 3), UsageError);
    EXPECT_THROW(support_matches(changes, std::vector<float>(4), 4), UsageError);
    EXPECT_THROW(support_matches(changes, std::vector<float>(4), 0), UsageError);
    EXPECT_THROW(support_overlap(kTrue, std::vector<double>(3)), UsageError);
}

}  // namespace
}  // namespace mscomp
