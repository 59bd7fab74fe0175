// SPDX-License-Identifier: MIT
#include "nn/trainer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/model/model_file.h"
#include "network_files.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

class Training : public testing::Test {
  protected:
    void TearDown() override { set_thread_count(0); }

    std::string temporary(const char* name) { return folder_ / name; }

  private:
    TemporaryFolder folder_;
};

std::vector<float> trained(SmallTraining& problem, int epochs) {
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < epochs; ++epoch) trainer.run_epoch();
    return all_of(*model);
}

// The same training with 1, 2 and 7 threads gives the same bits.
TEST_F(Training, ThreadsDoNotChangeABit) {
    SmallTraining problem;
    set_thread_count(1);
    const std::vector<float> one = trained(problem, 5);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(trained(problem, 5), one) << threads << " threads";
    }
}

// The same with batches that are gathered beside the steps.
TEST_F(Training, ThreadsDoNotChangeABitOfSmallBatches) {
    SmallTraining problem;
    problem.config.train.batch = 5;
    set_thread_count(1);
    const std::vector<float> one = trained(problem, 4);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(trained(problem, 4), one) << threads << " threads";
    }
}

/// Features in memory that count how often they are read, and fail from one read on.
class CountedFeatures final : public ShapeFeatures {
  public:
    CountedFeatures(std::span<const float> features, int vertices) : memory_(features, vertices) {}

    mutable int reads = 0;
    int reads_before_failure = std::numeric_limits<int>::max();

    int shape_count() const override { return memory_.shape_count(); }
    int vertex_count() const override { return memory_.vertex_count(); }
    std::span<const float> shape(int index) const override {
        if (++reads > reads_before_failure) throw InputError({"f.safetensors"}, "ends too early");
        return memory_.shape(index);
    }
    void forget(int) const override {}

  private:
    MemoryFeatures memory_;
};

// Scaled on the way, in whatever batches, features train as those that were scaled before.
TEST_F(Training, ScalingOnTheWayChangesNoBit) {
    SmallTraining problem;
    for (const int batch : {5, 12}) {
        problem.config.train.batch = batch;
        const std::vector<float> before = trained(problem, 3);
        // Powers of two: scaling there and back is exact.
        std::vector<float> unscaled = problem.features;
        const int vertices = problem.mesh.vertex_count();
        const MemoryFeatures memory(unscaled, vertices);
        ScaledFeatures features{memory};
        features.scale.factor.fill(4);
        for (int v = 0; v < vertices; ++v) features.scale.roots.push_back(v % 2 == 0 ? 2 : 0.5F);
        for (std::size_t i = 0; i < unscaled.size(); ++i) {
            unscaled[i] /= i / 9 % static_cast<std::size_t>(vertices) % 2 == 0 ? 8 : 2;
        }
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config.train, features, problem.shapes);
        trainer.start();
        for (int epoch = 0; epoch < 3; ++epoch) trainer.run_epoch();
        EXPECT_EQ(all_of(*model), before) << "batches of " << batch;
    }
}

TEST_F(Training, ReadsOnceWhatFitsIntoOneBatch) {
    SmallTraining problem;
    const CountedFeatures counted(problem.features, problem.mesh.vertex_count());
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, ScaledFeatures{counted}, problem.shapes);
    trainer.start();
    trainer.run_epoch();
    const int reads = counted.reads;
    trainer.run_epoch();
    trainer.codes();
    trainer.run_epoch();
    EXPECT_EQ(counted.reads, reads);
}

// What goes wrong in the thread that gathers stops training before the step that needs it.
TEST_F(Training, AFailureToReadStopsBeforeTheStep) {
    SmallTraining problem;
    problem.config.train.batch = 5;
    CountedFeatures counted(problem.features, problem.mesh.vertex_count());
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, ScaledFeatures{counted}, problem.shapes);
    trainer.start();
    counted.reads_before_failure = counted.reads + 7;  // in the second batch
    try {
        trainer.run_epoch();
        FAIL() << "trained on what could not be read";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), InputError({"f.safetensors"}, "ends too early").what());
    }
    EXPECT_EQ(trainer.state().step, 1);
}

// Saved, loaded into a fresh model and continued gives the bits of a run that never stopped, with
// batches smaller than the set, where the order of the shapes is drawn anew each epoch.
TEST_F(Training, ResumedIsUninterrupted) {
    SmallTraining problem;
    problem.config.train.batch = 5;
    const std::vector<float> whole = trained(problem, 8);

    const std::string path = temporary("resume.safetensors");
    ModelContext context;
    context.reference = problem.mesh;
    context.train_shapes = problem.shapes;
    {
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
        trainer.start();
        for (int epoch = 0; epoch < 3; ++epoch) trainer.run_epoch();
        write_network(path, *model, context, trainer.state(), trainer.codes());
    }
    const ModelFile file(path);
    EXPECT_EQ(file.state().epoch, 3);
    EXPECT_EQ(file.state().step, 9);
    const auto model = problem.make_model();
    load_network(file, *model);
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.resume(file.state());
    for (int epoch = 3; epoch < 8; ++epoch) trainer.run_epoch();
    EXPECT_EQ(all_of(*model), whole);
}

// Reading codes for a checkpoint does not disturb training.
TEST_F(Training, SavingOnTheWayChangesNothing) {
    SmallTraining problem;
    const std::vector<float> undisturbed = trained(problem, 4);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 4; ++epoch) {
        trainer.run_epoch();
        trainer.codes();
    }
    EXPECT_EQ(all_of(*model), undisturbed);
}

// As many components as the data have: reconstruction goes towards zero.
TEST_F(Training, OverfitsFourShapes) {
    SmallTraining problem(4, 2);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    double first = 0, last = 0;
    for (int epoch = 0; epoch < 300; ++epoch) {
        const EpochReport report = trainer.run_epoch();
        last = report.terms[3];
        if (epoch == 0) first = report.terms[0];
    }
    double energy = 0;
    for (const float x : problem.features)
        energy += static_cast<double>(x) * static_cast<double>(x);
    EXPECT_TRUE(first < 0.2 * energy / 4) << "the deflation start explains most: " << first;
    EXPECT_TRUE(last < 0.01 * energy / 4) << last << " of " << energy / 4;
}

// A feature that is not finite stops training before the update and names what broke.
TEST_F(Training, StopsAtNaNBeforeTheUpdate) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    trainer.run_epoch();
    const std::vector<float> before = all_of(*model);
    problem.features[100] = std::numeric_limits<float>::quiet_NaN();
    Trainer poisoned(*model, problem.config.train, problem.features, problem.shapes);
    poisoned.resume(trainer.state());
    try {
        poisoned.run_epoch();
        FAIL() << "trained on NaN";
    } catch (const NumericalError& error) {
        EXPECT_NE(std::string(error.what()).find("step 2: the result of autoencoder"),
                  std::string::npos)
            << error.what();
    }
    EXPECT_EQ(all_of(*model), before);
}

// Squares that float32 still holds have slopes that it does not; how large they may be is up to the
// kernels, and those of some processors never come to it.
TEST_F(Training, StopsAtAGradientThatIsNotFiniteBeforeTheUpdate) {
    bool is_found = false;
    for (const float factor : {1e18F, 3e18F, 1e19F}) {
        SmallTraining problem;
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
        trainer.start();
        for (float& x : problem.features) x *= factor;
        const std::vector<float> before = all_of(*model);
        Trainer large(*model, problem.config.train, problem.features, problem.shapes);
        large.resume(trainer.state());
        try {
            large.run_epoch();
        } catch (const NumericalError& error) {
            is_found = is_found ||
                       std::string(error.what()).find("the gradient of level") != std::string::npos;
            EXPECT_EQ(all_of(*model), before) << factor;
        }
    }
    if (!is_found) GTEST_SKIP() << "the loss is not finite where gradients are not";
}

// Between an update and saving: parameters, both moments, and what they give. No step has been that
// its error could be compared with.
TEST_F(Training, GivesNoCodesOfWhatIsNotFinite) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config.train, problem.features, problem.shapes);
    trainer.start();
    EXPECT_NO_THROW(trainer.codes());
    const auto refusal = [&](std::span<float> numbers, float x) {
        const std::vector<float> good(numbers.begin(), numbers.end());
        std::ranges::fill(numbers, x);
        const std::string message = thrown_message<NumericalError>([&] { trainer.codes(); });
        std::ranges::copy(good, numbers.begin());
        return message;
    };
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    ParameterSet<float>& parameters = model->parameters();
    EXPECT_THAT(refusal(parameters.all_values(), kNaN),
                testing::MatchesRegex("step 0: after its update level.* is not finite"));
    EXPECT_THAT(refusal(parameters.all_moments1(), kNaN), testing::HasSubstr("the first moment"));
    EXPECT_THAT(refusal(parameters.all_moments2(), kNaN), testing::HasSubstr("the second moment"));
    EXPECT_THAT(refusal(parameters.all_values(), 1e30F), testing::HasSubstr("the loss"));
}

}  // namespace
}  // namespace mscomp::nn
