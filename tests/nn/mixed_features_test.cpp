// SPDX-License-Identifier: MIT
#include "learning/mixed_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "mixing.h"

namespace mscomp::nn {
namespace {

// Shapes that are not among those to mix leave no trace in a row, whatever they are.
TEST(MixedFeatures, DoNotReadOtherShapes) {
    Mixing mixing({1, 2, 4});
    const std::size_t width = static_cast<std::size_t>(mixing.vertices()) * 9;
    for (const std::size_t other : {0U, 3U, 5U}) {
        std::fill_n(mixing.features.begin() + static_cast<std::ptrdiff_t>(other * width), width,
                    std::nanf(""));
    }
    for (int m = 0; m < 20; ++m) {
        for (const float x : mixing.row(m)) ASSERT_TRUE(std::isfinite(x));
    }
}

TEST(MixedFeatures, OfOneShapeAreThatShape) {
    const Mixing mixing({3});
    const std::span<const float> shape = mixing.memory.shape(3);
    for (int m = 0; m < 10; ++m) {
        const std::vector<float> row = mixing.row(m);
        ASSERT_EQ(row.size(), shape.size());
        for (std::size_t i = 0; i < row.size(); ++i) {
            EXPECT_TRUE(std::abs(row[i] - shape[i]) <= 1e-5F * (1 + std::abs(shape[i])));
        }
    }
}

// Convex combinations of the shapes at each vertex: in their hull, channel by channel.
TEST(MixedFeatures, LieBetweenTheShapesTheyFollow) {
    const std::vector<int> shapes{1, 2, 4};
    const Mixing mixing(shapes);
    for (int m = 0; m < 20; ++m) {
        const std::vector<float> row = mixing.row(m);
        for (std::size_t i = 0; i < row.size(); ++i) {
            float low = mixing.memory.shape(1)[i], high = low;
            for (const int shape : shapes) {
                low = std::min(low, mixing.memory.shape(shape)[i]);
                high = std::max(high, mixing.memory.shape(shape)[i]);
            }
            EXPECT_TRUE(row[i] >= low - 1e-5F && row[i] <= high + 1e-5F);
        }
    }
}

// A row is what its weights say of the shapes it follows.
TEST(MixedFeatures, AreTheWeightedSumOfTheShapesTheyFollow) {
    const Mixing mixing({0, 2, 5});
    for (const int m : {0, 7, 19}) {
        const std::vector<float> row = mixing.row(m);
        const MixedFeatures::Mix mix = mixing.mixed.mix(m);
        const std::size_t patches = mix.shapes.size();
        for (std::size_t i = 0; i < row.size(); ++i) {
            double sum = 0;
            for (std::size_t p = 0; p < patches; ++p) {
                sum += static_cast<double>(mix.weights[i / 9 * patches + p]) *
                       static_cast<double>(mixing.memory.shape(mix.shapes[p])[i]);
            }
            EXPECT_TRUE(std::abs(static_cast<double>(row[i]) - sum) <= 1e-5);
        }
    }
}

// Of two shapes that a patch follows it has a + t (b - a), t from -0.1 to 1.1; about as many
// patches as asked for, none otherwise, and the shapes drawn first are the same either way.
TEST(MixedFeatures, MayGoFromOneShapeToAnother) {
    const Mixing one, both({0, 1, 2, 3, 4, 5}, 2, 5, 0.4);
    int patches = 0, between = 0;
    for (int m = 0; m < 20; ++m) {
        const MixedFeatures::Mix plain = one.mixed.mix(m), mix = both.mixed.mix(m);
        EXPECT_EQ(mix.shapes, plain.shapes);
        EXPECT_EQ(mix.weights, plain.weights);
        EXPECT_EQ(plain.others, plain.shapes);
        const std::vector<float> row = both.row(m);
        std::vector<double> wanted(row.size(), 0.0);
        const std::size_t count = mix.shapes.size();
        for (std::size_t p = 0; p < count; ++p) {
            ++patches;
            between += mix.ways[p] != 0 ? 1 : 0;
            EXPECT_TRUE(mix.ways[p] >= -0.1F && mix.ways[p] <= 1.1F) << mix.ways[p];
            EXPECT_EQ(plain.ways[p], 0.0F);
            const auto from = both.memory.shape(mix.shapes[p]),
                       to = both.memory.shape(mix.others[p]);
            for (std::size_t i = 0; i < row.size(); ++i) {
                const auto a = static_cast<double>(from[i]), b = static_cast<double>(to[i]);
                wanted[i] += static_cast<double>(mix.weights[i / 9 * count + p]) *
                             (a + static_cast<double>(mix.ways[p]) * (b - a));
            }
        }
        for (std::size_t i = 0; i < row.size(); ++i) ASSERT_NEAR(row[i], wanted[i], 1e-5);
    }
    EXPECT_NEAR(between, 0.4 * patches, 0.1 * patches);
}

// A function of seed and number: whatever was asked for before, forgotten, and by another object.
TEST(MixedFeatures, AreAFunctionOfSeedAndNumber) {
    const Mixing one, two, other({0, 1, 2, 3, 4, 5}, 2, 6);
    const int count = one.memory.shape_count();
    std::vector<std::vector<float>> rows;
    for (int m = 0; m < 12; ++m) rows.push_back(one.row(m));
    for (int m = 11; m >= 0; --m) EXPECT_EQ(two.row(m), rows[static_cast<std::size_t>(m)]);
    for (const int m : {3, 0, 11}) {
        one.mixed.forget(count + m);
        EXPECT_EQ(one.row(m), rows[static_cast<std::size_t>(m)]);
    }
    for (std::size_t m = 1; m < rows.size(); ++m) EXPECT_NE(rows[m], rows[0]);
    EXPECT_NE(other.row(0), rows[0]) << "another seed";
}

/// Counts how often shapes are asked for.
class CountedShapes final : public ShapeFeatures {
  public:
    explicit CountedShapes(const ShapeFeatures& shapes) : shapes_(shapes) {}

    mutable int reads = 0, forgotten = 0;

    int shape_count() const override { return shapes_.shape_count(); }
    int vertex_count() const override { return shapes_.vertex_count(); }
    std::span<const float> shape(int index) const override {
        ++reads;
        return shapes_.shape(index);
    }
    void forget(int) const override { ++forgotten; }

  private:
    const ShapeFeatures& shapes_;
};

// A row is kept until it is forgotten, and no longer: then it is made again.
TEST(MixedFeatures, KeepRowsUntilTheyAreForgotten) {
    Mixing mixing;
    const CountedShapes counted(mixing.memory);
    const std::vector<int> shapes{0, 1, 2};
    const MixedFeatures mixed(counted, shapes, mixing.distances, mixing.order.to_user, 5);
    const float* row = mixed.shape(6).data();
    const int reads = counted.reads;
    EXPECT_GT(reads, 0);
    EXPECT_EQ(mixed.shape(6).data(), row);
    EXPECT_EQ(counted.reads, reads);
    mixed.forget(6);
    mixed.shape(6);
    EXPECT_EQ(counted.reads, 2 * reads);
    EXPECT_EQ(counted.forgotten, 0);
    mixed.forget(2);
    EXPECT_EQ(counted.forgotten, 1);
}

TEST(MixedFeatures, MayBeAskedFromSeveralThreads) {
    const Mixing one, many;
    constexpr int kThreads = 7, kEach = 6;
    const int count = many.memory.shape_count();
    std::vector<std::vector<std::vector<float>>> got(kThreads);
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t) {
        threads.emplace_back([&, t] {
            for (int i = 0; i < kEach; ++i) {
                const int m = i * kThreads + t;
                got[static_cast<std::size_t>(t)].push_back(many.row(m));
                if (i % 2 == 0) many.mixed.forget(count + m);
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    for (int t = 0; t < kThreads; ++t) {
        for (int i = 0; i < kEach; ++i) {
            EXPECT_EQ(got[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)],
                      one.row(i * kThreads + t));
        }
    }
}

TEST(MixedFeatures, ShapesBeforeTheMixesAreTheFeatures) {
    const Mixing mixing({1, 2});
    EXPECT_EQ(mixing.mixed.shape_count(), 6);
    EXPECT_EQ(mixing.mixed.vertex_count(), mixing.vertices());
    for (int shape = 0; shape < 6; ++shape) {
        EXPECT_EQ(mixing.mixed.shape(shape).data(), mixing.memory.shape(shape).data());
    }
}

// Distances come in the inner numbering, weights and rows in that of the user: with the same inner
// numbering, vertices renumbered by the user have the same mixes at their new places.
TEST(MixedFeatures, FollowARenumberingOfTheUser) {
    const Mixing plain;
    Mixing other;  // distances of other are the inner ones; the user's numbering is moved
    const std::size_t count = static_cast<std::size_t>(plain.vertices());
    VertexOrder order = other.order;
    const auto moved = [&](std::size_t v) { return (v * 5 + 3) % count; };
    for (std::size_t v = 0; v < count; ++v) {
        order.to_user[v] = static_cast<int>(moved(v));
        order.to_internal[moved(v)] = static_cast<int>(v);
    }
    std::vector<float> features(plain.features.size());
    for (std::size_t i = 0; i < features.size(); ++i) {
        const std::size_t shape = i / 9 / count, v = i / 9 % count;
        features[(shape * count + moved(v)) * 9 + i % 9] = plain.features[i];
    }
    const MemoryFeatures memory(features, plain.vertices());
    const std::vector<int> shapes{0, 1, 2, 3, 4, 5};
    const MixedFeatures renumbered(memory, shapes, other.distances, order.to_user, 5);
    for (const int m : {0, 8}) {
        const std::vector<float> wanted = plain.row(m);
        const std::span<const float> got = renumbered.shape(6 + m);
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            ASSERT_EQ(got[moved(i / 9) * 9 + i % 9], wanted[i]);
        }
    }
}

}  // namespace
}  // namespace mscomp::nn
