// SPDX-License-Identifier: MIT
// Training on shapes and mixes of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <set>

#include "base/temporary_folder.h"
#include "mscomp/base/parallel.h"
#include "mscomp/model/model_file.h"
#include "network_files.h"
#include "nn/trainer.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

constexpr int kShapes = 6, kFilled = 14;

/// Six shapes filled up to fourteen, in three batches.
struct MixedTraining : SmallTraining {
    explicit MixedTraining(int batch = 5) : SmallTraining(kShapes, 3) {
        config.train.fill_up_to = kFilled;
        config.train.batch = batch;
    }
};

std::vector<float> trained(MixedTraining& problem, int epochs) {
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < epochs; ++epoch) trainer.run_epoch();
    return all_of(*model);
}

class MixedTrainingTest : public testing::Test {
  protected:
    void TearDown() override { set_thread_count(0); }
    TemporaryFolder folder_;
};

TEST_F(MixedTrainingTest, EpochsAreFilledUp) {
    TrainConfig config;
    config.fill_up_to = 48;
    EXPECT_EQ(epoch_size(config, 36, 1000), 48);
    EXPECT_EQ(epoch_size(config, 48, 1000), 48);
    EXPECT_EQ(epoch_size(config, 49, 1000), 49);
    // Large meshes take the lanes that are there: 20 shapes have 32.
    EXPECT_EQ(epoch_size(config, 20, 200000), 48);
    EXPECT_EQ(epoch_size(config, 20, 200001), 32);
    config.fill_below = 24;
    EXPECT_EQ(epoch_size(config, 23, 1000), 48);
    EXPECT_EQ(epoch_size(config, 24, 1000), 24);
    config.fill_up_to = 0;
    EXPECT_EQ(epoch_size(config, 1, 1000), 1);
}

// One batch of all of them, and batches that are drawn and gathered beside the steps; mixes change
// after epoch 8.
TEST_F(MixedTrainingTest, ThreadsDoNotChangeABit) {
    for (const int batch : {kFilled, 5}) {
        MixedTraining problem(batch);
        set_thread_count(1);
        const std::vector<float> one = trained(problem, 10);
        for (const int threads : {2, 7}) {
            set_thread_count(threads);
            EXPECT_EQ(trained(problem, 10), one) << threads << " threads, batches of " << batch;
        }
    }
}

// Saved after `saved` epochs, loaded into a fresh model and continued: the bits of a run that never
// stopped. Before, at and after a change of the mixes.
TEST_F(MixedTrainingTest, ResumedIsUninterrupted) {
    for (const int batch : {kFilled, 5}) {
        MixedTraining problem(batch);
        constexpr int kEpochs = 18;
        const std::vector<float> whole = trained(problem, kEpochs);
        for (const int saved : {3, 7, 8, 9, 16}) {
            const std::string path = folder_ / "resume.safetensors";
            ModelContext context;
            context.reference = problem.mesh;
            context.train_shapes = problem.shapes;
            {
                const auto model = problem.make_model();
                Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
                trainer.start();
                for (int epoch = 0; epoch < saved; ++epoch) trainer.run_epoch();
                write_network(path, *model, context, trainer.state(), trainer.codes());
            }
            const ModelFile file(path);
            const auto model = problem.make_model();
            load_network(file, *model);
            Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
            trainer.resume(file.state());
            for (int epoch = saved; epoch < kEpochs; ++epoch) trainer.run_epoch();
            EXPECT_EQ(all_of(*model), whole) << "saved at " << saved << ", batches of " << batch;
        }
    }
}

// Mixes end with training: codes are those of the shapes, as a model alone gives them.
TEST_F(MixedTrainingTest, CodesAreThoseOfTheShapes) {
    for (const int batch : {kFilled, 5, 4}) {
        MixedTraining problem(batch);
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
        trainer.start();
        for (int epoch = 0; epoch < 2; ++epoch) trainer.run_epoch();
        const CodeTable codes = trainer.codes();
        ASSERT_EQ(codes.code_count, 3 + 6);
        ASSERT_EQ(codes.shape_count(), kShapes);
        for (std::size_t shape = 0; shape < kShapes; ++shape) {
            const std::vector<int> alone{static_cast<int>(shape)};
            model->load_batch(std::span<const float>(problem.features),
                              std::span<const int>(alone));
            model->forward();
            const std::vector<float> wanted = model->codes(0);
            for (std::size_t k = 0; k < 3; ++k) {
                EXPECT_NEAR(codes.shape(alone[0])[k], wanted[k], 1e-5) << "shape " << shape;
            }
        }
    }
}

/// Says of which shapes it was asked; of those with NaN nobody may ask.
class WatchedFeatures final : public ShapeFeatures {
  public:
    WatchedFeatures(std::span<const float> features, int vertices) : memory_(features, vertices) {}

    int shape_count() const override { return memory_.shape_count(); }
    int vertex_count() const override { return memory_.vertex_count(); }
    std::span<const float> shape(int index) const override {
        const std::lock_guard lock(mutex_);
        read_.insert(index);
        return memory_.shape(index);
    }
    void forget(int) const override {}
    std::set<int> read() const { return read_; }

  private:
    MemoryFeatures memory_;
    mutable std::mutex mutex_;
    mutable std::set<int> read_;
};

// Shapes that are not trained on are not mixed into training either.
TEST_F(MixedTrainingTest, ReadsTrainingShapesOnly) {
    MixedTraining problem;
    problem.shapes = {0, 2, 5};
    const WatchedFeatures watched(problem.features, problem.mesh.vertex_count());
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, ScaledFeatures{watched}, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 9; ++epoch) trainer.run_epoch();
    trainer.codes();
    EXPECT_EQ(watched.read(), (std::set<int>{0, 2, 5}));
}

// With shapes enough, filling up to fewer, as many or none is the same training.
TEST_F(MixedTrainingTest, OfShapesEnoughMixesNothing) {
    MixedTraining problem;
    problem.config.train.fill_up_to = 0;
    const std::vector<float> plain = trained(problem, 4);
    for (const int fill : {3, kShapes}) {
        problem.config.train.fill_up_to = fill;
        EXPECT_EQ(trained(problem, 4), plain) << fill;
    }
    problem.config.train.fill_up_to = kShapes + 1;
    EXPECT_NE(trained(problem, 4), plain);
}

// Mixes are scaled as shapes are: (x - offset) factor commutes with weights that sum to 1.
TEST_F(MixedTrainingTest, MixesAreScaledLikeShapes) {
    MixedTraining problem;
    const std::vector<float> before = trained(problem, 2);
    std::vector<float> unscaled = problem.features;
    for (float& x : unscaled) x /= 4;  // exact, there and back
    const MemoryFeatures memory(unscaled, problem.mesh.vertex_count());
    ScaledFeatures features{memory};
    features.scale.factor.fill(4);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 2; ++epoch) trainer.run_epoch();
    EXPECT_EQ(all_of(*model), before);
}

// A step without a rate leaves parameters alone: the loss of an epoch then says which shapes it
// had, the same mixes for eight epochs, others for the next eight.
TEST_F(MixedTrainingTest, MixesChangeEveryEightEpochs) {
    MixedTraining problem(kFilled);
    problem.config.train.learning_rate = problem.config.train.learning_rate_floor = 0;
    problem.config.train.supports = false;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    std::vector<double> totals;
    for (int epoch = 0; epoch < 24; ++epoch) totals.push_back(trainer.run_epoch().total);
    for (std::size_t epoch = 0; epoch < 24; ++epoch) {
        EXPECT_EQ(totals[epoch], totals[epoch / 8 * 8]) << "epoch " << epoch;
    }
    EXPECT_NE(totals[0], totals[8]);
    EXPECT_NE(totals[8], totals[16]);
    EXPECT_NE(totals[0], totals[16]);
}

}  // namespace
}  // namespace mscomp::nn
