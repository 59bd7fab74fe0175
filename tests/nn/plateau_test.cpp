// SPDX-License-Identifier: MIT
// When training ends before its last epoch.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/model_file.h"
#include "network_files.h"
#include "nn/trainer.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

/// A trainer at its start.
struct Trial {
    SmallTraining& problem;
    std::unique_ptr<StackedModel<float>> model = problem.make_model();
    Trainer trainer{*model, problem.config.train, problem.features, problem.shapes};

    explicit Trial(SmallTraining& of) : problem(of) { trainer.start(); }

    /// Errors of the epochs, both levels, until it is over.
    std::vector<double> to_the_end() {
        std::vector<double> totals;
        while (!trainer.is_over()) {
            const EpochReport report = trainer.run_epoch();
            totals.push_back(report.terms[0] + report.terms[3]);
        }
        return totals;
    }
};

class Plateau : public testing::Test {
  protected:
    Plateau() {
        set_thread_count(1);  // many tiny passes
        problem_.config.train.epochs = 200;
        problem_.config.train.plateau_epochs = 4;
        problem_.config.train.learning_rate = 3e-3;
    }

    void TearDown() override { set_thread_count(0); }

    ModelContext context() const {
        ModelContext context;
        context.reference = problem_.mesh;
        context.train_shapes = problem_.shapes;
        return context;
    }
    /// A trainer that goes on from a file.
    std::unique_ptr<Trial> resumed(const ModelFile& file) {
        auto run = std::make_unique<Trial>(problem_);
        load_network(file, *run->model);
        run->trainer.resume(file.state());
        return run;
    }
    void stand_still() {
        problem_.config.train.learning_rate = problem_.config.train.learning_rate_floor = 0;
        problem_.config.train.supports = false;
    }

    SmallTraining problem_;
    TemporaryFolder folder_;
};

double mean(const std::vector<double>& totals, std::size_t first, std::size_t count) {
    double sum = 0;
    for (std::size_t i = first; i < first + count; ++i) sum += totals[i];
    return sum / static_cast<double>(count);
}

// An error that stays is a plateau for any gain; it takes two whole windows to know.
TEST_F(Plateau, NeedsTwoWholeWindows) {
    stand_still();
    for (const int window : {1, 4, 7}) {
        problem_.config.train.plateau_epochs = window;
        Trial run(problem_);
        EXPECT_EQ(run.to_the_end().size(), static_cast<std::size_t>(2 * window));
        EXPECT_TRUE(run.trainer.state().is_plateau);
    }
}

// The end is the first window whose mean is less than the gain below that of the one before.
TEST_F(Plateau, EndsWhereAWindowGainsTooLittle) {
    for (const double gain : {0.1, 0.15}) {
        problem_.config.train.plateau_epochs = 0;
        const std::vector<double> all = Trial(problem_).to_the_end();
        ASSERT_EQ(all.size(), 200U);
        std::size_t end = 8;
        while (mean(all, end - 4, 4) <= (1 - gain) * mean(all, end - 8, 4)) end += 4;
        ASSERT_GT(end, 8U) << "nothing gained from the first window on";
        ASSERT_LT(end, 200U);

        problem_.config.train.plateau_epochs = 4;
        problem_.config.train.plateau_gain = gain;
        Trial run(problem_);
        EXPECT_EQ(run.to_the_end(),
                  std::vector<double>(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(end)));
    }
}

TEST_F(Plateau, OfZeroEpochsNeverEnds) {
    stand_still();
    problem_.config.train.epochs = 20;
    problem_.config.train.plateau_epochs = 0;
    Trial run(problem_);
    EXPECT_EQ(run.to_the_end().size(), 20U);
    EXPECT_FALSE(run.trainer.state().is_plateau);
}

// Whenever it was saved, in the middle of a window too, a resumed run ends at the same epoch.
TEST_F(Plateau, EndsAtTheSameEpochAfterAResume) {
    problem_.config.train.plateau_gain = 0.15;
    const std::size_t end = Trial(problem_).to_the_end().size();
    ASSERT_GT(end, 8U);
    for (const std::size_t saved : {std::size_t{3}, std::size_t{4}, std::size_t{6}, end - 1}) {
        Trial first(problem_);
        for (std::size_t epoch = 0; epoch < saved; ++epoch) first.trainer.run_epoch();
        const std::string path = folder_ / "model.safetensors";
        write_network(path, *first.model, context(), first.trainer.state(), first.trainer.codes());
        const ModelFile file(path);
        EXPECT_EQ(file.state().window_mean, first.trainer.state().window_mean);
        EXPECT_EQ(file.state().window_sum, first.trainer.state().window_sum);
        EXPECT_EQ(file.state().window_epochs, static_cast<std::int64_t>(saved % 4));
        EXPECT_FALSE(file.state().is_plateau);
        EXPECT_EQ(saved + resumed(file)->to_the_end().size(), end) << "saved at " << saved;
    }
}

TEST_F(Plateau, IsKeptInTheFile) {
    stand_still();
    Trial run(problem_);
    run.to_the_end();
    const std::string path = folder_ / "model.safetensors";
    write_network(path, *run.model, context(), run.trainer.state(), run.trainer.codes());
    const ModelFile file(path);
    EXPECT_TRUE(file.state().is_plateau);
    EXPECT_TRUE(resumed(file)->trainer.is_over());
    // Who no longer wants to stop on plateaus goes on to the last epoch.
    problem_.config.train.plateau_epochs = 0;
    problem_.config.train.epochs = 15;
    EXPECT_EQ(resumed(file)->to_the_end().size(), 15U - 8U);
}

/// Copies a model file with `window` instead of its window, or none.
void copy_with_window(const std::string& from, const std::string& to,
                      const std::vector<double>& window) {
    const SafetensorsFile file(from);
    SafetensorsWriter writer;
    for (const std::string& name : file.names()) {
        if (name == "plateau") continue;
        const Shape shape = file.shape(name);
        const auto add = [&]<class T>(T) { writer.add<T>(name, shape, file.data<T>(name, shape)); };
        switch (file.type(name)) {
            case DataType::f32:
                add(float{});
                break;
            case DataType::f64:
                add(double{});
                break;
            case DataType::i32:
                add(std::int32_t{});
                break;
            case DataType::u8:
                add(std::uint8_t{});
                break;
            default:
                FAIL() << name;
        }
    }
    if (!window.empty()) {
        writer.add<double>("plateau", {static_cast<std::int64_t>(window.size())}, window);
    }
    writer.set_metadata("model", file.metadata().at("model"));
    writer.write(to);
}

// Files written before there were plateaus, or before windows were counted, are read; training
// goes on from them, and the part of a window that they do not know is not taken for a whole one:
// an error that still falls by more than the gain is no plateau.
TEST_F(Plateau, OfAnOldFileBeginsItsWindowAnew) {
    problem_.config.train.plateau_gain = 5e-4;
    problem_.config.train.plateau_epochs = 0;
    const std::vector<double> all = Trial(problem_).to_the_end();
    ASSERT_LE(mean(all, 10, 4), (1 - 5e-4) * mean(all, 6, 4)) << "it falls all the time";
    ASSERT_LE(mean(all, 14, 4), (1 - 5e-4) * mean(all, 10, 4));
    problem_.config.train.plateau_epochs = 4;
    Trial first(problem_);
    for (int epoch = 0; epoch < 6; ++epoch) first.trainer.run_epoch();
    const std::string path = folder_ / "new.safetensors", old = folder_ / "old.safetensors";
    write_network(path, *first.model, context(), first.trainer.state(), first.trainer.codes());
    const double before = first.trainer.state().window_mean;
    for (const std::vector<double>& window :
         {std::vector<double>{}, std::vector<double>{before, 1.0, 0.0}}) {
        copy_with_window(path, old, window);
        const ModelFile file(old);
        EXPECT_EQ(file.state().epoch, 6);
        EXPECT_EQ(file.state().window_epochs, 0);
        EXPECT_EQ(file.state().window_sum, 0);
        EXPECT_EQ(file.state().window_mean, window.empty() ? 0 : before);
        const auto run = resumed(file);
        for (int epoch = 6; epoch < 18; ++epoch) {
            EXPECT_FALSE(run->trainer.is_over()) << "after epoch " << epoch;
            run->trainer.run_epoch();
        }
        EXPECT_NEAR(run->trainer.state().window_mean / mean(all, 14, 4), 1, 1e-12);
    }
}

// A window that is made longer on the way is whole when it has as many epochs as it says.
TEST_F(Plateau, WindowsOfAnotherLengthAreCountedToo) {
    problem_.config.train.plateau_epochs = 5;
    Trial run(problem_);
    for (int epoch = 0; epoch < 7; ++epoch) run.trainer.run_epoch();
    problem_.config.train.plateau_epochs = 20;
    for (int epoch = 7; epoch < 24; ++epoch) run.trainer.run_epoch();
    EXPECT_EQ(run.trainer.state().window_epochs, 19);
    const double sum = run.trainer.state().window_sum;
    const EpochReport last = run.trainer.run_epoch();
    EXPECT_DOUBLE_EQ(run.trainer.state().window_mean, (sum + last.terms[0] + last.terms[3]) / 20);
    EXPECT_EQ(run.trainer.state().window_epochs, 0);
}

}  // namespace
}  // namespace mscomp::nn
