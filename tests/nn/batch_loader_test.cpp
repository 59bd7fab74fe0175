// SPDX-License-Identifier: MIT
#include "nn/batch_loader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <numeric>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

std::vector<float> random_features(int shapes, int vertices) {
    const CounterRandom random(3, 1);
    std::vector<float> features(static_cast<std::size_t>(shapes * vertices * 9));
    for (std::size_t i = 0; i < features.size(); ++i) {
        features[i] = static_cast<float>(6 * random.uniform(i) - 3);
    }
    return features;
}

VertexOrder random_order(int vertices) {
    VertexOrder order;
    order.to_user = CounterRandom(5, 1).permutation(vertices);
    order.to_internal.resize(order.to_user.size());
    for (int v = 0; v < vertices; ++v) {
        order.to_internal[static_cast<std::size_t>(order.to_user[static_cast<std::size_t>(v)])] = v;
    }
    return order;
}

ScaledFeatures scaled(const ShapeFeatures& shapes, bool has_roots = false) {
    ScaledFeatures scaled{
        shapes, {{0.1, -0.2, 0.3, 1, 0, 0, 1, 0, 1}, {0.7, 0.7, 0.7, 3.3, 3.3, 3.3, 0, 5, 1e-3}}};
    for (int v = 0; has_roots && v < shapes.vertex_count(); ++v) {
        scaled.scale.roots.push_back(0.5F + 0.01F * static_cast<float>(v));
    }
    return scaled;
}

/// Features in memory, with something to be done before each shape is handed out.
class WatchedFeatures final : public ShapeFeatures {
  public:
    WatchedFeatures(std::span<const float> features, int vertices)
        : memory_(features, vertices), in_use_(static_cast<std::size_t>(memory_.shape_count())) {}

    std::function<void(int)> before = [](int) {};
    mutable std::atomic<int> reads = 0, most_in_use = 0;

    int shape_count() const override { return memory_.shape_count(); }
    int vertex_count() const override { return memory_.vertex_count(); }
    std::span<const float> shape(int index) const override {
        before(index);
        ++reads;
        in_use_[static_cast<std::size_t>(index)] = 1;
        most_in_use = std::max(most_in_use.load(), in_use());
        return memory_.shape(index);
    }
    void forget(int index) const override { in_use_[static_cast<std::size_t>(index)] = 0; }
    int in_use() const { return std::accumulate(in_use_.begin(), in_use_.end(), 0); }

  private:
    MemoryFeatures memory_;
    mutable std::vector<int> in_use_;
};

template <class T>
void expect_definition(int vertices, int lanes, int count, GatherThreads threads,
                       bool has_roots = false) {
    const std::vector<float> features = random_features(count + 2, vertices);
    const MemoryFeatures memory(features, vertices);
    const ScaledFeatures source = scaled(memory, has_roots);
    const VertexOrder order = random_order(vertices);
    std::vector<int> which(static_cast<std::size_t>(count));
    std::iota(which.rbegin(), which.rend(), 2);
    AlignedVector<T> rows(static_cast<std::size_t>(vertices * 9 * lanes), T{7});
    gather_lanes(source, which, order, std::span<T>(rows), threads);
    for (int v = 0; v < vertices; ++v) {
        for (int c = 0; c < 9; ++c) {
            for (int l = 0; l < lanes; ++l) {
                float wanted = 0;
                if (l < count) {
                    const auto channel = static_cast<std::size_t>(c);
                    const int user = order.to_user[static_cast<std::size_t>(v)];
                    const int shape = which[static_cast<std::size_t>(l)];
                    const double feature =
                        features[static_cast<std::size_t>((shape * vertices + user) * 9 + c)];
                    wanted = static_cast<float>(
                        (feature - source.scale.offset[channel]) *
                        (source.scale.factor[channel] * source.scale.root(at(user))));
                }
                ASSERT_EQ(rows[static_cast<std::size_t>((v * 9 + c) * lanes + l)], T{wanted})
                    << "vertex " << v << ", channel " << c << ", lane " << l << " of " << count;
            }
        }
    }
}

// Row (v,c), lane l is (feature - offset) factor root of user vertex, channel and shape, for every
// count of vertices around the size of a tile and every filling of the lanes.
TEST(GatherLanes, PutsEveryNumberInItsPlace) {
    for (const int vertices : {1, 3, 31, 32, 33, 65, 100}) {
        for (const auto& [lanes, count] : {std::pair(8, 1), std::pair(8, 8), std::pair(16, 9),
                                           std::pair(32, 16), std::pair(48, 36)}) {
            expect_definition<float>(vertices, lanes, count, GatherThreads::one);
            expect_definition<double>(vertices, lanes, count, GatherThreads::all);
            expect_definition<float>(vertices, lanes, count, GatherThreads::all, true);
        }
    }
}

TEST(GatherLanes, ThreadsDoNotChangeABit) {
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        expect_definition<float>(5000, 16, 13, GatherThreads::all);
    }
    set_thread_count(0);
}

// However large the batch: what has been gathered need not stay.
TEST(GatherLanes, HoldsNoMoreThanSixteenShapes) {
    const std::vector<float> features = random_features(50, 10);
    const WatchedFeatures source(features, 10);
    std::vector<int> which(50);
    std::iota(which.begin(), which.end(), 0);
    AlignedVector<float> rows(10 * 9 * 64);
    gather_lanes(scaled(source), which, random_order(10), std::span<float>(rows),
                 GatherThreads::one);
    EXPECT_EQ(source.reads, 50);
    EXPECT_EQ(source.in_use(), 0);
    EXPECT_LE(source.most_in_use, 16);
}

constexpr int kVertices = 40;
constexpr int kShapes = 9;

class Loader : public testing::Test {
  protected:
    Loader() : loader_(scaled(source_), order_, 8) {}

    void expect_batch(const LaneBatch* batch, const std::vector<int>& which) {
        ASSERT_NE(batch, nullptr);
        EXPECT_EQ(batch->shapes, which);
        AlignedVector<float> rows(kVertices * 9 * 8);
        gather_lanes(scaled(source_), which, order_, std::span<float>(rows), GatherThreads::one);
        EXPECT_EQ(batch->rows, rows);
    }

    const std::vector<float> features_ = random_features(kShapes, kVertices);
    WatchedFeatures source_{features_, kVertices};
    const VertexOrder order_ = random_order(kVertices);
    BatchLoader loader_;
};

TEST_F(Loader, GivesWhatWasAskedFor) {
    for (const std::vector<int>& which :
         {std::vector{3, 1, 4}, std::vector{8}, std::vector{0, 2}}) {
        loader_.prepare(which);
        expect_batch(loader_.take(which), which);
    }
}

TEST_F(Loader, HasNothingElse) {
    EXPECT_EQ(loader_.take(std::vector{1, 2}), nullptr);
    loader_.prepare(std::vector{1, 2});
    EXPECT_EQ(loader_.take(std::vector{2, 1}), nullptr);
    EXPECT_EQ(loader_.take(std::vector{1}), nullptr);
    expect_batch(loader_.take(std::vector{1, 2}), {1, 2});
}

TEST_F(Loader, AnotherWishReplacesTheFirst) {
    loader_.prepare(std::vector{1, 2});
    loader_.prepare(std::vector{5});
    EXPECT_EQ(loader_.take(std::vector{1, 2}), nullptr);
    expect_batch(loader_.take(std::vector{5}), {5});
}

// The caller goes on while shapes are read: here they come only after prepare has returned.
TEST_F(Loader, WorksBesideTheCaller) {
    std::promise<void> returned;
    source_.before = [gate = returned.get_future().share()](int) { gate.wait(); };
    loader_.prepare(std::vector{6, 7});
    returned.set_value();
    const LaneBatch* batch = loader_.take(std::vector{6, 7});
    source_.before = [](int) {};
    expect_batch(batch, {6, 7});
}

TEST_F(Loader, AFailureReachesTheCallerWhole) {
    source_.before = [](int shape) {
        if (shape == 4) throw InputError({"f.safetensors", 12, 3}, "ends too early");
    };
    loader_.prepare(std::vector{3, 4});
    try {
        loader_.take(std::vector{3, 4});
        FAIL() << "took what could not be read";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), InputError({"f.safetensors", 12, 3}, "ends too early").what());
    }
    // It says so once; the loader is as good as before.
    source_.before = [](int) {};
    EXPECT_EQ(loader_.take(std::vector{3, 4}), nullptr);
    loader_.prepare(std::vector{3, 4});
    expect_batch(loader_.take(std::vector{3, 4}), {3, 4});
}

// A batch that nobody takes harms nobody.
TEST_F(Loader, AFailureOfWhatIsGivenUpIsForgotten) {
    source_.before = [](int shape) {
        if (shape == 4) throw InputError({"f.safetensors"}, "ends too early");
    };
    loader_.prepare(std::vector{4});
    loader_.prepare(std::vector{5});
    expect_batch(loader_.take(std::vector{5}), {5});
}

TEST_F(Loader, MayGoWhileItIsAtWork) {
    for (int i = 0; i < 50; ++i) {
        BatchLoader short_lived(scaled(source_), order_, 8);
        short_lived.prepare(std::vector{1, 2, 3});
    }
}

}  // namespace
}  // namespace mscomp::nn
