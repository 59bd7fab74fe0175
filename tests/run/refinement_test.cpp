// SPDX-License-Identifier: MIT
// Runs that begin with the components of others and lower their error in space.
#include "mscomp/run/refinement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/config/config_file.h"
#include "mscomp/eval/measures.h"
#include "mscomp/multiscale/multiscale.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/shape_decoder.h"
#include "mscomp/run/trained_run.h"
#include "mscomp/run/training_run.h"
#include "run/run_cases.h"

namespace mscomp {
namespace {

using testing::HasSubstr;

Config small_start(const std::string& kind, const std::string& features) {
    Config config = cases::small_config(kind, features);
    config.train.epochs = 30;
    if (auto* own = std::any_cast<MultiscaleSettings>(&config.settings)) {
        own->global_components = 1;
        own->levels = {{3, 0.4, 0.5}, {4, 0.3, 0.3}};
        own->rounds = 3;
        config.train.epochs = 3;
    }
    return config;
}

class RefinedRun : public testing::Test {
  protected:
    std::string run(const std::string& name) const { return folder_ / name; }
    /// A run of the kind to begin with.
    std::string trained(const std::string& kind) const {
        train_run(small_start(kind, features_), run("first.run"));
        return run("first.run");
    }
    Config refined(int epochs = 3) const {
        Config config = refined_config(run("first.run"));
        config.train.epochs = epochs;
        return config;
    }
    void train(const Config& config, const std::string& name, int stop_after = -1,
               bool resume = false) const {
        TrainingOptions options;
        options.resume = resume;
        int epochs = 0;
        options.on_epoch = [&](const EpochReport&, const std::vector<std::string>&) { ++epochs; };
        options.should_stop = [&] { return epochs == stop_after; };
        train_run(config, run(name), options);
    }
    std::string bits(const std::string& name) const {
        return read_file(checkpoint_path(run(name)));
    }
    /// E_rms of codes fitted to the vertices of the training shapes.
    double space_error(const std::string& name) const {
        TrainedRun opened = open_run(run(name), 5);
        const FeatureFile file(features_);
        ShapeDecoder decoder(opened, file, [] {});
        const std::vector<int>& shapes = opened.context().train_shapes;
        const std::vector<DecodedShape> fitted = decoder.fit(shapes, decoder.encode(shapes));
        RmsError error(opened.reference().vertices);
        for (std::size_t m = 0; m < shapes.size(); ++m) {
            error.add(decoder.truth(shapes[m]), fitted[m].vertices);
        }
        return error.value();
    }
    void expect_refused(const Config& config, const std::string& why) const {
        try {
            train_run(config, run("refused.run"));
            ADD_FAILURE() << "not refused: " << why;
        } catch (const UsageError& error) {
            EXPECT_THAT(error.what(), HasSubstr(why));
        }
        EXPECT_FALSE(has_checkpoint(run("refused.run")));
    }

    TemporaryFolder folder_;
    std::string features_ = cases::extracted_arm(folder_ / "arm.safetensors");
};

/// The vertices that each component changes.
std::vector<std::set<int>> supports(const TrainedRun& run) {
    std::vector<std::set<int>> all;
    for (const CodeColumn& column : given_components(*run.model, run.file.codes()).changes) {
        all.emplace_back(column.vertices.begin(), column.vertices.end());
    }
    return all;
}

class RefinedKind : public RefinedRun, public testing::WithParamInterface<std::string> {};

TEST_P(RefinedKind, ComesNearerInSpaceToWhatItLearnsFrom) {
    trained(GetParam());
    train(refined(4), "second.run");
    EXPECT_LT(space_error("second.run"), 0.97 * space_error("first.run"));
}

// Levels, ids, parents and supports are those of the first run: what was exactly zero stays so.
TEST_P(RefinedKind, KeepsWhatComponentsAre) {
    trained(GetParam());
    train(refined(), "second.run");
    TrainedRun first = open_run(run("first.run")), second = open_run(run("second.run"));
    EXPECT_EQ(second.config.kind, "multiscale");
    EXPECT_EQ(supports(second), supports(first));
    const std::vector<Component> before = first.components(), after = second.components();
    ASSERT_EQ(after.size(), before.size());
    for (std::size_t k = 0; k < before.size(); ++k) {
        EXPECT_EQ(after[k].id, before[k].id);
        EXPECT_EQ(after[k].center, before[k].center);
        EXPECT_EQ(after[k].support, supports(first)[k].size());
    }
    EXPECT_EQ(second.context().train_shapes, first.context().train_shapes);
}

// Before the first epoch components are those of the first run, in direction.
TEST_P(RefinedKind, BeginsWithTheComponents) {
    trained(GetParam());
    train(refined(1), "second.run");
    const TrainedRun first = open_run(run("first.run")), second = open_run(run("second.run"));
    const auto before = given_components(*first.model, first.file.codes());
    const auto after = given_components(*second.model, second.file.codes());
    for (std::size_t k = 0; k < before.changes.size(); ++k) {
        double product = 0, a = 0, b = 0;
        for (std::size_t i = 0; i < before.changes[k].values.size(); ++i) {
            const auto x = static_cast<double>(before.changes[k].values[i]);
            const auto y = static_cast<double>(after.changes[k].values[i]);
            product += x * y;
            a += x * x;
            b += y * y;
        }
        if (a > 0) {
            EXPECT_GT(product / std::sqrt(a * b), 0.8) << "component " << k;
        }
    }
}

// Stopped and gone on with after the first run is gone, with any number of threads: the same bits.
TEST_P(RefinedKind, GoesOnWithoutTheFirstRunInTheSameBits) {
    trained(GetParam());
    const Config config = refined();
    train(config, "whole.run");
    const std::string hash = ModelFile(checkpoint_path(run("first.run"))).data_hash();
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        train(config, "whole" + std::to_string(threads) + ".run");
        EXPECT_EQ(bits("whole" + std::to_string(threads) + ".run"), bits("whole.run"));
        train(config, "parts" + std::to_string(threads) + ".run", 1);
    }
    std::filesystem::remove_all(run("first.run"));
    for (const int threads : {7, 2, 1}) {
        set_thread_count(threads);
        const std::string parts = "parts" + std::to_string(threads) + ".run";
        train(read_config(config_path(run(parts)), {}), parts, -1, true);
        EXPECT_EQ(bits(parts), bits("whole.run")) << threads << " threads";
        EXPECT_EQ(ModelFile(checkpoint_path(run(parts))).context().start_hash, hash);
    }
    set_thread_count(0);
    EXPECT_THAT(read_file(log_path(run("whole.run"))), HasSubstr(hash));
}

INSTANTIATE_TEST_SUITE_P(Kinds, RefinedKind,
                         testing::Values("stacked-attention", "autoencoder", "spectral-vae",
                                         "multiscale"),
                         [](const auto& kind) {
                             std::string name = kind.param;
                             std::erase(name, '-');
                             return name;
                         });

// What the configuration says of levels is true of the components, and reads back as it is.
TEST_F(RefinedRun, ConfigurationSaysHowFarComponentsReach) {
    trained("stacked-attention");
    const Config config = refined();
    const Config again = parse_config(write_config(config, true), "refined");
    EXPECT_EQ(write_config(again, true), write_config(config, true));
    TrainedRun first = open_run(run("first.run"));
    const auto& own = config.own<MultiscaleSettings>();
    ASSERT_EQ(own.levels.size(), 2U);
    EXPECT_EQ(own.global_components, 0);
    const std::vector<std::set<int>> all = supports(first);
    const std::vector<ComponentPlace> places = first.model->places();
    std::size_t k = 0;
    for (const BallLevel& level : own.levels) {
        double range = 0, share = 0;
        for (int i = 0; i < level.components; ++i, ++k) {
            for (const int v : all[k]) {
                range = std::max(range, first.distances->row(places[k].center)[at(v)]);
            }
            share = std::max(share,
                             static_cast<double>(all[k].size()) / first.reference().vertex_count());
        }
        EXPECT_GE(level.sparsity_range, range);
        EXPECT_LE(level.sparsity_range, range + 0.001 + 1e-12);
        EXPECT_GE(level.max_support, share);
        EXPECT_LE(level.max_support, share + 0.001 + 1e-12);
    }
    EXPECT_EQ(k, all.size());
}

TEST_F(RefinedRun, ComponentsOfPositionsAreRefused) {
    trained("pca");
    EXPECT_THROW(refined(), UsageError);
    Config config = small_start("multiscale", features_);
    config.train.start_run = run("first.run");
    expect_refused(config, "is of kind pca");
}

TEST_F(RefinedRun, AnotherMeshIsRefused) {
    trained("autoencoder");
    Config config = refined();
    const GeneratedSequence longer = generate_arm(9, 3, 400);
    config.data.features = folder_ / "longer.safetensors";
    write_features(config.data.features,
                   extract_features(longer.sequence, longer.sequence.shapes.front()));
    expect_refused(config, "has another reference than");
    const GeneratedSequence arm = generate_arm(9, 3, 300);
    write_features(config.data.features, extract_features(arm.sequence, arm.sequence.shapes[4]));
    expect_refused(config, "has another reference than");
}

TEST_F(RefinedRun, OtherFeaturesAreRefused) {
    trained("autoencoder");
    Config config = refined();
    config.data.features = folder_ / "more.safetensors";
    GeneratedSequence arm = generate_arm(9, 3, 300);
    ExtractOptions uniform;
    uniform.weights = EdgeWeights::uniform;
    write_features(config.data.features,
                   extract_features(arm.sequence, arm.sequence.shapes.front(), uniform));
    expect_refused(config, "was trained on other features than");
    std::swap(arm.sequence.shapes[3], arm.sequence.shapes[4]);
    write_features(config.data.features,
                   extract_features(arm.sequence, arm.sequence.shapes.front()));
    expect_refused(config, "was trained on other features than");
}

// Shapes that the first run has seen are not unseen because the second one has not.
TEST_F(RefinedRun, ShapesThatWereSeenCannotBeTested) {
    trained("autoencoder");
    Config config = refined();
    config.data.split.step = 4;
    expect_refused(config, "has learnt from shapes that data.split leaves to test");
    config.data.split.train = SplitKind::all;
    EXPECT_NO_THROW(train_run(config, run("all.run")));
}

// For sweeps: a run that began with what is another run by now has to begin anew; one whose
// beginning is gone has not.
TEST_F(RefinedRun, IsFinishedAsLongAsItsBeginningIsTheSame) {
    trained("autoencoder");
    const Config config = refined();
    train(config, "second.run");
    const TrainingDemand demand{config, FeatureFile(features_).data_hash(), {0, 2, 4, 6, 8}};
    EXPECT_EQ(training_progress(run("second.run"), demand), TrainingProgress::finished);
    Config other = small_start("autoencoder", features_);
    other.train.seed = 5;
    other.train.epochs = 2;
    train_run(other, run("first.run"));
    EXPECT_EQ(training_progress(run("second.run"), demand), TrainingProgress::none);
    std::filesystem::remove_all(run("first.run"));
    EXPECT_EQ(training_progress(run("second.run"), demand), TrainingProgress::finished);
}

TEST_F(RefinedRun, OtherLevelsAreRefused) {
    trained("autoencoder");
    Config config = refined();
    config.own<MultiscaleSettings>().levels.front().components += 1;
    expect_refused(config, "train.start: levels of 2 components, wanted those of");
}

}  // namespace
}  // namespace mscomp
