// SPDX-License-Identifier: MIT
// After the first steps nothing on the way of a step asks for memory. This executable counts every
// call of operator new, of all threads.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "mscomp/base/parallel.h"
#include "nn/batch_loader.h"
#include "nn/optimizer.h"
#include "nn/start.h"
#include "small_training.h"

namespace {

std::atomic<std::int64_t> allocations = 0;

void* counted(std::size_t size, std::size_t alignment) {
    ++allocations;
    alignment = std::max(alignment, sizeof(void*));
    const std::size_t whole = (std::max<std::size_t>(size, 1) + alignment - 1) / alignment;
    void* memory = std::aligned_alloc(alignment, whole * alignment);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

constexpr std::size_t kPlain = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

}  // namespace

// The forms for arrays and those that do not throw end in these.
void* operator new(std::size_t size) { return counted(size, kPlain); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace mscomp::nn {
namespace {

/// How often each part of a step asked for memory, as far as it did.
using Counts = std::map<std::string, std::int64_t>;

template <class Body>
void count(Counts& counts, const std::string& part, Body&& body) {
    const std::int64_t before = allocations;
    body();
    if (allocations > before) counts[part] += allocations - before;
}

/// Steps of a training as Trainer makes them, part by part.
class CountedSteps {
  public:
    CountedSteps(int threads, int batch) {
        set_thread_count(threads);
        problem_.config.train.batch = batch;
        model_ = problem_.make_model();
        start_deflation(*model_, features_, std::span<const int>(problem_.shapes));
        loader_ = std::make_unique<BatchLoader>(features_, model_->order(),
                                                lane_count(model_->batch_capacity()));
    }
    ~CountedSteps() { set_thread_count(0); }

    Counts run(int steps) {
        Counts counts;
        for (int i = 0; i < steps; ++i) step(counts);
        return counts;
    }

  private:
    void step(Counts& counts) {
        const auto size = static_cast<std::size_t>(model_->batch_capacity());
        const auto shapes = std::span<const int>(problem_.shapes);
        const std::span<const int> batch = step_ % 2 == 0 ? shapes.first(size) : shapes.last(size);
        count(counts, "gathering", [&] {
            loader_->prepare(batch);
            model_->load_batch(*loader_->take(batch));
        });
        Tape<float>& tape = model_->tape();
        for (const auto& op : tape.ops()) {
            count(counts, std::string(op->name()) + " forward", [&] { op->forward(tape); });
        }
        count(counts, "zero_grad", [&] { model_->parameters().zero_grad(); });
        count(counts, "backward of the tape", [&] { model_->backward(); });
        for (const auto& op : tape.ops()) {
            if (!tape.needs_grad(op->output())) continue;
            count(counts, std::string(op->name()) + " backward", [&] { op->backward(tape); });
        }
        ++step_;
        count(counts, "Adam", [&] { adam_step(model_->parameters(), 1e-6, step_); });
        count(counts, "proximal step", [&] { proximal_step(*model_, 1.0, 1e-6, step_); });
    }

    SmallTraining problem_;
    const MemoryFeatures memory_{problem_.features, problem_.mesh.vertex_count()};
    const ScaledFeatures features_{memory_};
    std::unique_ptr<StackedModel<float>> model_;
    std::unique_ptr<BatchLoader> loader_;
    std::int64_t step_ = 0;
};

std::int64_t allocations_of_parallel_for() {
    set_thread_count(2);
    std::int64_t most = 0;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t before = allocations;
        parallel_for(2, [](std::int64_t) {});
        most = allocations - before;  // the first call makes the threads
    }
    return most;
}

void expect_none(int threads, int batch) {
    if (threads > 1 && allocations_of_parallel_for() > 0) {
        GTEST_SKIP() << "parallel_for itself allocates, whatever the op";
    }
    CountedSteps training(threads, batch);
    training.run(2);
    // A thread takes its own scratch memory when it first gets a piece of an op, which may be late;
    // what allocates in every step does so in every three.
    constexpr int kTries = 20;
    Counts counts;
    for (int attempt = 0; attempt < kTries; ++attempt) {
        counts = training.run(3);
        if (counts.empty()) return;
    }
    for (const auto& [part, times] : counts) {
        ADD_FAILURE() << part << ": " << times << " allocations in three steps";
    }
}

// The counting itself: plain, aligned and array forms, and those of other threads.
TEST(Allocations, AreCountedWhateverTheirForm) {
    Counts counts;
    count(counts, "plain", [] { std::make_unique<int>(1); });
    count(counts, "array", [] { std::make_unique<int[]>(5); });
    count(counts, "aligned", [] { AlignedVector<float>(5); });
    count(counts, "none", [] { set_thread_count(1); });
    set_thread_count(2);
    count(counts, "threads", [] { parallel_for(64, [](std::int64_t) { std::vector<int>(9); }); });
    set_thread_count(0);
    EXPECT_EQ(counts["plain"], 1);
    EXPECT_EQ(counts["array"], 1);
    EXPECT_EQ(counts["aligned"], 1);
    EXPECT_FALSE(counts.contains("none"));
    EXPECT_GE(counts["threads"], 64);
}

TEST(Allocations, NoneInAStepOfAFullBatch) { expect_none(1, 12); }
TEST(Allocations, NoneInAStepOfASmallBatch) { expect_none(1, 5); }
TEST(Allocations, NoneInAStepOnTwoThreads) { expect_none(2, 12); }
TEST(Allocations, NoneInAStepOfASmallBatchOnTwoThreads) { expect_none(2, 5); }

}  // namespace
}  // namespace mscomp::nn
