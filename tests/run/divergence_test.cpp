// SPDX-License-Identifier: MIT
// Runs whose rate is far too high: they go back and halve it, in the same bits however they are
// stopped, or end with an error; what they leave is always good.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/trained_run.h"
#include "mscomp/run/training_run.h"
#include "run/run_cases.h"

namespace mscomp {
namespace {

class DivergingRun : public testing::TestWithParam<std::string> {
  protected:
    Config config(double rate) const {
        Config config = cases::small_config(GetParam(), features_);
        config.train.epochs = 14;
        config.train.checkpoint_every = 5;
        config.train.learning_rate = rate;
        return config;
    }
    std::string run(const char* name = "arm.run") const { return folder_ / name; }
    std::vector<std::string> setbacks_;

    TrainingResult train(const Config& config, const std::string& run, bool resume = false,
                         std::int64_t stop_after = -1) {
        TrainingOptions options;
        options.resume = resume;
        options.on_setback = [this](const TrainingState&, const std::string& what) {
            setbacks_.push_back(what);
        };
        int epochs = 0;
        options.on_epoch = [&](const EpochReport&, const std::vector<std::string>&) { ++epochs; };
        if (stop_after >= 0) options.should_stop = [&] { return epochs >= stop_after; };
        return train_run(config, run, options);
    }
    /// All that is in the checkpoint, bit for bit.
    static std::string bits(const std::string& run) { return read_file(checkpoint_path(run)); }
    static int rows(const std::string& run) {
        const std::string text = read_file(metrics_path(run));
        return static_cast<int>(std::ranges::count(text, '\n')) - 1;
    }
    /// A rate from which a few halvings lead to one that trains.
    double wild_rate() {
        for (const double rate : {1.0, 5.0, 20.0, 0.2}) {
            setbacks_.clear();
            try {
                train(config(rate), run("probe.run"));
            } catch (const NumericalError&) {
                break;
            }
            std::filesystem::remove_all(run("probe.run"));
            if (!setbacks_.empty()) return rate;
        }
        ADD_FAILURE() << "no rate was wild, or all too wild";
        return 1;
    }

    TemporaryFolder folder_;
    std::string features_ = cases::extracted_arm(folder_ / "arm.safetensors");
};

// Ten halvings of 1e38 do not help: the error is said, and the start is what is left.
TEST_P(DivergingRun, EndsWithAnErrorAndAGoodCheckpoint) {
    for (const double rate : {1e38, 1e20}) {
        Config one = config(rate);
        one.train.epochs = 1;
        EXPECT_THROW(train(one, run()), NumericalError) << rate;
        EXPECT_EQ(setbacks_.size(), 10U) << rate;
        TrainedRun opened = open_run(run());
        EXPECT_EQ(opened.file.state().epoch, 0);
        EXPECT_FALSE(opened.components().empty());
        EXPECT_FALSE(std::filesystem::exists(milestone_path(run())));
        std::filesystem::remove_all(run());
        setbacks_.clear();
    }
}

TEST_P(DivergingRun, GoesBackAndTrainsAtALowerRate) {
    const double rate = wild_rate();
    setbacks_.clear();
    const TrainingResult result = train(config(rate), run());
    ASSERT_FALSE(setbacks_.empty());
    EXPECT_EQ(result.state.epoch, 14);
    EXPECT_EQ(result.state.rate_factor, std::ldexp(1, -static_cast<int>(setbacks_.size())));
    EXPECT_EQ(open_run(run()).file.state().rate_factor, result.state.rate_factor);
    EXPECT_EQ(rows(run()), 14) << "what was undone leaves no row";
    const std::string log = read_file(log_path(run()));
    for (const std::string& what : setbacks_) {
        EXPECT_NE(log.find(what), std::string::npos) << what;
        EXPECT_NE(what.find("went back to epoch"), std::string::npos) << what;
    }
}

// Stopped after every number of epochs, before and behind the setbacks, and gone on with.
TEST_P(DivergingRun, StoppedAndResumedIsUninterrupted) {
    const double rate = wild_rate();
    train(config(rate), run("whole.run"));
    const std::string whole = bits(run("whole.run"));
    for (const std::int64_t first : {1, 4, 6, 9}) {
        bool is_stopped = train(config(rate), run(), false, first).is_stopped;
        for (int piece = 0; is_stopped && piece < 60; ++piece) {
            is_stopped = train(config(rate), run(), true, 2).is_stopped;
        }
        EXPECT_TRUE(bits(run()) == whole) << "stopped first after " << first;
        EXPECT_FALSE(std::filesystem::exists(milestone_path(run())));
        std::filesystem::remove_all(run());
    }
}

// A look at the model at any other time, saved or not, does not decide how training goes on.
TEST_P(DivergingRun, SavedWheneverSomebodyAsksIsTheSame) {
    for (const double rate : {wild_rate(), 1.0, 5.0, 20.0}) {
        const auto bits_of = [&](bool is_asked) {
            std::filesystem::remove_all(run());
            TrainingOptions options;
            options.should_save = [&] { return is_asked; };
            try {
                train_run(config(rate), run(), options);
            } catch (const NumericalError&) {
                return std::string("no rate helps");
            }
            return bits(run());
        };
        EXPECT_TRUE(bits_of(true) == bits_of(false)) << rate;
    }
}

// Where a model is not fit to be saved as somebody asks, training goes on; who stops there is left
// with the last milestone.
TEST_P(DivergingRun, WhatCannotBeSavedInBetweenIsLeftOut) {
    const Config wild = config(1e19);
    EXPECT_TRUE(train(wild, run(), false, 1).is_stopped);
    EXPECT_EQ(open_run(run()).file.state().epoch, 0);
    EXPECT_EQ(open_run(run()).file.state().rate_factor, 1);
    EXPECT_TRUE(setbacks_.empty());
    EXPECT_EQ(rows(run()), 0);
    TrainingOptions options;
    options.should_save = [] { return true; };
    EXPECT_THROW(train_run(wild, run("asked.run"), options), NumericalError);
    for (const std::string& log : {log_path(run()), log_path(run("asked.run"))}) {
        EXPECT_NE(read_file(log).find("; not saved"), std::string::npos);
    }
}

// A sound rate never goes back.
TEST_P(DivergingRun, DoesNotGoBackAtASoundRate) {
    Config sound = config(3e-3);
    sound.train.epochs = 60;
    train(sound, run());
    EXPECT_TRUE(setbacks_.empty()) << setbacks_.front();
}

// Before Adam has seen a gradient twice it goes as far at every value; along a limb that adds up.
class RunOnLimb : public testing::TestWithParam<int> {};

TEST_P(RunOnLimb, OfFittedComponentsDoesNotGoBack) {
    const TemporaryFolder folder;
    const GeneratedSequence arm = generate_arm(12, 0, GetParam());
    write_features(folder / "arm.safetensors",
                   extract_features(arm.sequence, arm.sequence.shapes.front()));
    Config config = default_config("multiscale");
    config.data.features = folder / "arm.safetensors";
    config.train.fill_up_to = 0;
    config.train.epochs = 32;
    std::vector<std::string> setbacks;
    TrainingOptions options;
    options.on_setback = [&](const TrainingState&, const std::string& what) {
        setbacks.push_back(what);
    };
    train_run(config, folder / "arm.run", options);
    EXPECT_TRUE(setbacks.empty()) << setbacks.front();
}

INSTANTIATE_TEST_SUITE_P(Sizes, RunOnLimb, testing::Values(400));

INSTANTIATE_TEST_SUITE_P(Kinds, DivergingRun,
                         testing::Values("stacked-attention", "autoencoder", "spectral-vae"),
                         [](const auto& kind) {
                             std::string name = kind.param;
                             std::erase(name, '-');
                             return name;
                         });

}  // namespace
}  // namespace mscomp
