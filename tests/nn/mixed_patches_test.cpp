// SPDX-License-Identifier: MIT
// Patches of mixed shapes: where they lie, and how they blend.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "learning/deflation.h"
#include "mixing.h"

namespace mscomp::nn {
namespace {

void expect_weights_sum_to_one(const MixedFeatures::Mix& mix, int vertices) {
    const std::size_t patches = mix.shapes.size();
    ASSERT_EQ(mix.weights.size(), static_cast<std::size_t>(vertices) * patches);
    for (std::size_t v = 0; v < static_cast<std::size_t>(vertices); ++v) {
        double sum = 0;
        for (std::size_t p = 0; p < patches; ++p) {
            const double weight = static_cast<double>(mix.weights[v * patches + p]);
            EXPECT_TRUE(weight >= 0);
            sum += weight;
        }
        EXPECT_TRUE(std::abs(sum - 1) <= 1e-5) << "vertex " << v << ": " << sum;
    }
}

// At every vertex weights are a partition of one.
TEST(MixedPatches, WeightsOfAVertexSumToOne) {
    const Mixing mixing;
    for (int m = 0; m < 50; ++m) expect_weights_sum_to_one(mixing.mixed.mix(m), mixing.vertices());
}

// 4 to 40 patches, both ends included; each follows one of the shapes to mix, and over many mixes
// every one of them is followed.
TEST(MixedPatches, FollowAllOfTheirShapesAndNoOther) {
    const std::vector<int> shapes{1, 2, 4};
    const Mixing mixing(shapes);
    std::set<int> followed;
    std::set<std::size_t> patches;
    for (int m = 0; m < 600; ++m) {
        const MixedFeatures::Mix mix = mixing.mixed.mix(m);
        followed.insert(mix.shapes.begin(), mix.shapes.end());
        patches.insert(mix.shapes.size());
    }
    EXPECT_EQ(followed, std::set<int>(shapes.begin(), shapes.end()));
    EXPECT_EQ(*patches.begin(), 4U);
    EXPECT_EQ(*patches.rbegin(), 40U);
}

/// Whether weights of patches p and q are as those of middles a and b: log(w_p / w_q) = (d_b -
/// d_a) / 0.05 wherever both are there.
bool fits(const MixedFeatures::Mix& mix, std::size_t p, std::span<const double> a, std::size_t q,
          std::span<const double> b) {
    const std::size_t patches = mix.shapes.size();
    bool has_both = false;
    for (std::size_t v = 0; v < a.size(); ++v) {
        const double at_p = static_cast<double>(mix.weights[v * patches + p]);
        const double at_q = static_cast<double>(mix.weights[v * patches + q]);
        // What is far beyond the nearest middle counts nothing.
        if (at_p == 0 && at_q > 0.1 && a[v] - b[v] < 0.25) return false;
        if (at_q == 0 && at_p > 0.1 && b[v] - a[v] < 0.25) return false;
        if (at_p == 0 || at_q == 0) continue;
        has_both = true;
        if (!(std::abs(std::log(at_p / at_q) - (b[v] - a[v]) / 0.05) <= 1e-3)) return false;
    }
    return has_both;
}

/// Middles of the patches among `candidates`, found from the weights alone.
std::vector<int> middles_of(const MixedFeatures::Mix& mix, const std::vector<int>& candidates,
                            SphereDistances& distances) {
    for (const int first : candidates) {
        std::vector<int> middles{first};
        for (std::size_t p = 1; p < mix.shapes.size(); ++p) {
            for (std::size_t q = 0; q < p && middles.size() == p; ++q) {
                for (const int other : candidates) {
                    if (!fits(mix, p, distances.row(other), q, distances.row(middles[q]))) continue;
                    middles.push_back(other);
                    break;
                }
            }
            if (middles.size() == p) break;
        }
        if (middles.size() == mix.shapes.size()) return middles;
    }
    return {};
}

// w_p ~ exp(-d_p / 0.05) around distinct spread vertices; so at a middle with no other within
// 0.3, others weigh less than exp(-6) each, and the row is the followed shape but for this.
TEST(MixedPatches, FollowOneShapeAroundTheMiddleOfAPatch) {
    Mixing mixing;
    const std::vector<int> spread = spread_vertices(mixing.distances, 64);
    int alone = 0;
    for (int m = 0; m < 60; ++m) {
        const MixedFeatures::Mix mix = mixing.mixed.mix(m);
        const std::size_t patches = mix.shapes.size();
        if (patches > 9) continue;
        const std::vector<int> middles = middles_of(mix, spread, mixing.distances);
        ASSERT_EQ(middles.size(), patches) << "weights of no middles, mix " << m;
        EXPECT_EQ(std::set<int>(middles.begin(), middles.end()).size(), patches);
        const std::vector<float> row = mixing.row(m);
        for (std::size_t p = 0; p < patches; ++p) {
            const auto distance = mixing.distances.row(middles[p]);
            if (!std::ranges::all_of(middles, [&](int other) {
                    return other == middles[p] || distance[static_cast<std::size_t>(other)] > 0.3;
                })) {
                continue;
            }
            ++alone;
            const double others = static_cast<double>(patches - 1) * std::exp(-6);
            for (std::size_t c = 0; c < 9; ++c) {
                const std::size_t i = static_cast<std::size_t>(middles[p]) * 9 + c;
                // Random features differ by at most 10.
                EXPECT_TRUE(std::abs(row[i] - mixing.memory.shape(mix.shapes[p])[i]) <=
                            static_cast<float>(10 * others));
            }
        }
    }
    EXPECT_GT(alone, 5);
}

// Fewer vertices than there are spread ones: as many patches as vertices at most.
TEST(MixedPatches, OfFewVertices) {
    const Mixing mixing({0, 1, 2, 3, 4, 5}, 0);
    ASSERT_EQ(mixing.vertices(), 12);
    std::size_t most = 0;
    for (int m = 0; m < 100; ++m) {
        const MixedFeatures::Mix mix = mixing.mixed.mix(m);
        EXPECT_GE(mix.shapes.size(), 4U);
        most = std::max(most, mix.shapes.size());
        expect_weights_sum_to_one(mix, 12);
    }
    EXPECT_EQ(most, 12U);
}

/// Distances of a mesh of three vertices in a row.
class ThreeInARow final : public DistanceRows {
  public:
    int vertex_count() const override { return 3; }
    std::span<const double> row(int vertex) override {
        return std::span(rows_).subspan(static_cast<std::size_t>(vertex) * 3, 3);
    }

  private:
    std::vector<double> rows_{0, 0.5, 1, 0.5, 0, 0.5, 1, 0.5, 0};
};

// With fewer vertices than the fewest patches, each vertex is a patch: as 0.5 is far beyond the
// blend, rows follow one shape each.
TEST(MixedPatches, OfThreeVerticesFollowOneShapeEach) {
    ThreeInARow distances;
    const std::vector<float> features = Mixing::random_features(2, 3);
    const MemoryFeatures memory(features, 3);
    const std::vector<int> shapes{0, 1};
    const MixedFeatures mixed(memory, shapes, distances, as_it_is(3).to_user, 1);
    for (int m = 0; m < 10; ++m) {
        ASSERT_EQ(mixed.mix(m).shapes.size(), 3U);
        const std::span<const float> row = mixed.shape(2 + m);
        for (std::size_t v = 0; v < 3; ++v) {
            const auto follows = [&](int shape) {
                return std::ranges::equal(row.subspan(v * 9, 9),
                                          memory.shape(shape).subspan(v * 9, 9));
            };
            EXPECT_TRUE(follows(0) || follows(1)) << "vertex " << v << " of mix " << m;
        }
    }
}

/// Two spheres, each the other's other component: 1 away, and half as wide as that.
class TwoSpheres final : public DistanceRows {
  public:
    explicit TwoSpheres(SphereDistances& sphere) : count_(sphere.vertex_count()) {
        for (int v = 0; v < 2 * count_; ++v) {
            std::vector<double> row(static_cast<std::size_t>(2 * count_), 1.0);
            const auto near = sphere.row(v % count_);
            for (std::size_t i = 0; i < near.size(); ++i) {
                row[i + (v < count_ ? 0 : near.size())] = near[i] / 2;
            }
            rows_.push_back(std::move(row));
        }
    }
    int vertex_count() const override { return 2 * count_; }
    std::span<const double> row(int vertex) override {
        return rows_[static_cast<std::size_t>(vertex)];
    }

  private:
    int count_;
    std::vector<std::vector<double>> rows_;
};

// Patches do not reach into another connected component that has one of its own: no vertex of it
// is more than 0.5 from a middle, and the other component is 1 away.
TEST(MixedPatches, StayWithinAConnectedComponent) {
    SphereDistances sphere(shapes::icosphere(1).vertices);
    const int half = sphere.vertex_count();
    TwoSpheres distances(sphere);
    const std::vector<float> features = Mixing::random_features(3, 2 * half);
    const MemoryFeatures memory(features, 2 * half);
    const std::vector<int> shapes{0, 1, 2};
    const MixedFeatures mixed(memory, shapes, distances, as_it_is(2 * half).to_user, 9);
    int parted = 0;
    for (int m = 0; m < 60; ++m) {
        const MixedFeatures::Mix mix = mixed.mix(m);
        expect_weights_sum_to_one(mix, 2 * half);
        const std::size_t patches = mix.shapes.size();
        const auto is_in = [&](std::size_t p, int first) {
            for (int v = first; v < first + half; ++v) {
                if (mix.weights[static_cast<std::size_t>(v) * patches + p] > 0) return true;
            }
            return false;
        };
        std::size_t left = 0, right = 0, both = 0;
        for (std::size_t p = 0; p < patches; ++p) {
            const bool is_left = is_in(p, 0), is_right = is_in(p, half);
            EXPECT_TRUE(is_left || is_right);
            left += is_left;
            right += is_right;
            both += is_left && is_right;
        }
        // All patches in one component: the other has none near and takes all alike.
        EXPECT_TRUE(both == 0 || both == patches) << both << " of " << patches;
        parted += both == 0 && left > 0 && right > 0;
    }
    EXPECT_GT(parted, 40);
}

}  // namespace
}  // namespace mscomp::nn
