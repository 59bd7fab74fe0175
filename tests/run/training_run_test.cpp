// SPDX-License-Identifier: MIT
// Runs as a program uses them that is not ours: trained, opened, gone on with, decoded.
#include "mscomp/run/training_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/config/config_file.h"
#include "mscomp/eval/measures.h"
#include "mscomp/run/config_change.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/shape_decoder.h"
#include "mscomp/run/trained_run.h"
#include "mscomp/units/units.h"
#include "run/run_cases.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::StartsWith;

class TrainingRun : public testing::Test {
  protected:
    Config config(const std::string& kind = "stacked-attention") const {
        return cases::small_config(kind, features_);
    }
    std::string run() const { return folder_ / "arm.run"; }
    TrainingResult train(const Config& config, bool resume = false) const {
        TrainingOptions options;
        options.resume = resume;
        return train_run(config, run(), options);
    }
    /// Everything of the checkpoint but the configuration that stands in it.
    std::vector<float> arrays() const {
        TrainedRun opened = open_run(run());
        std::vector<float> all = opened.file.codes().values;
        const std::vector<float> codes(static_cast<std::size_t>(opened.model->code_count()), 0.5F);
        const std::vector<float> rows = opened.model->decode(codes);
        all.insert(all.end(), rows.begin(), rows.end());
        return all;
    }
    TrainingDemand demand(const Config& config) const {
        const FeatureFile file(features_);
        return {config, file.data_hash(), {0, 2, 4, 6, 8}};
    }

    TemporaryFolder folder_;
    std::string features_ = cases::extracted_arm(folder_ / "arm.safetensors");
};

TEST_F(TrainingRun, LeavesWhatOpensAgain) {
    const TrainingResult result = train(config());
    EXPECT_EQ(result.state.epoch, 3);
    EXPECT_FALSE(result.is_stopped);
    TrainedRun opened = open_run(run());
    EXPECT_EQ(opened.file.state().epoch, 3);
    EXPECT_EQ(opened.context().train_shapes, (std::vector<int>{0, 2, 4, 6, 8}));
    EXPECT_EQ(static_cast<int>(opened.components().size()), opened.model->code_count());
    for (const std::string& path : {metrics_path(run()), log_path(run()), config_path(run())}) {
        EXPECT_TRUE(std::filesystem::exists(path)) << path;
    }
}

// Of the training shapes alone, decoded from the codes in the file, as the scale counts; whatever
// the kind decodes to.
TEST_F(TrainingRun, KeepsTheErrorOfItsTrainingShapes) {
    for (const char* kind : {"stacked-attention", "pca"}) {
        std::filesystem::remove_all(run());
        train(config(kind));
        TrainedRun opened = open_run(run());
        const FeatureFile file(features_);
        const bool has_features = opened.model->rows() == ShapeRows::features;
        double squares = 0;
        for (int m = 0; m < 5; ++m) {
            std::vector<float> rows = opened.model->decode(opened.file.codes().shape(m));
            const std::span<const float> own =
                has_features ? file.shape(2 * m) : file.vertices(2 * m);
            std::vector<float> truth(own.begin(), own.end());
            if (has_features) {
                opened.context().scale.scale(rows);
                opened.context().scale.scale(truth);
            }
            for (std::size_t i = 0; i < rows.size(); ++i) {
                squares +=
                    std::pow(static_cast<double>(rows[i]) - static_cast<double>(truth[i]), 2);
            }
        }
        ASSERT_TRUE(opened.context().squared_error.has_value());
        EXPECT_GT(squares, 0);
        EXPECT_NEAR(*opened.context().squared_error, squares, 1e-4 * squares) << kind;
    }
}

/// Features of an arm with one frame in another unit and one whose vertices come from the other
/// end, written by a program that has no warnings.
void write_odd_features(const std::string& path) {
    GeneratedSequence arm = generate_arm(9, 3, 300);
    for (Point& p : arm.sequence.shapes[2]) {
        for (double& coordinate : p) coordinate *= 1000;
    }
    std::ranges::reverse(arm.sequence.shapes[5]);
    PlacedFeatures set = extract_features(arm.sequence, arm.sequence.shapes.front());
    set.warnings.clear();
    write_features(path, set);
}

TEST_F(TrainingRun, WarnsItselfOfWholeShapesThatAreOdd) {
    std::vector<std::string> warnings;
    TrainingOptions options;
    options.on_warning = [&](const std::string& sentence) { warnings.push_back(sentence); };
    train_run(config(), run(), options);
    EXPECT_THAT(warnings, IsEmpty());

    write_odd_features(features_);
    train_run(config(), folder_ / "odd.run", options);
    const std::string in_other_order =
        "1 of 9 shapes (first: 'frame_0005') seem to have their vertices in another order";
    const std::string of_other_size =
        "1 of 9 shapes (first: 'frame_0002') have another size than the reference";
    EXPECT_THAT(warnings, IsSupersetOf({StartsWith(in_other_order), StartsWith(of_other_size)}));
    const std::string log = read_file(log_path(folder_ / "odd.run"));
    for (const std::string& warning : warnings) EXPECT_THAT(log, HasSubstr("warning: " + warning));
}

// A filter that drops everything, on a run that is finished: nothing is trained, and whoever opens
// the run obeys it.
TEST_F(TrainingRun, ResumedWithAnotherFilterIsSavedAndObeyed) {
    Config changed = config();
    train(changed);
    const std::vector<float> before = arrays();
    ASSERT_TRUE(std::ranges::any_of(open_run(run()).components(), &Component::kept));
    changed.filter.rule = FilterRule::strength;
    changed.filter.minimum_strength = 1e9;
    const TrainingResult result = train(changed, true);
    EXPECT_EQ(result.state.epoch, 3);
    TrainedRun opened = open_run(run());
    EXPECT_EQ(opened.config.filter.minimum_strength, 1e9);
    EXPECT_TRUE(std::ranges::none_of(opened.components(), &Component::kept));
    EXPECT_EQ(read_config(config_path(run()), {}).filter.minimum_strength, 1e9);
    EXPECT_EQ(arrays(), before);
}

// In two pieces, the second with more epochs, or at once: the same numbers.
TEST_F(TrainingRun, ResumedEndsWhereTheWholeWayEnds) {
    Config longer = config();
    longer.train.epochs = 6;
    train(longer);
    const std::vector<float> whole = arrays();
    std::filesystem::remove_all(run());
    train(config());
    train(longer, true);
    EXPECT_EQ(arrays(), whole);
}

TEST_F(TrainingRun, StopsWhenAskedWithEverythingSaved) {
    TrainingOptions options;
    int epochs = 0;
    options.on_epoch = [&](const EpochReport& report, const std::vector<std::string>& terms) {
        EXPECT_EQ(report.terms.size(), terms.size());
        ++epochs;
    };
    options.should_stop = [&] { return epochs == 2; };
    const TrainingResult result = train_run(config(), run(), options);
    EXPECT_TRUE(result.is_stopped);
    EXPECT_EQ(result.state.epoch, 2);
    EXPECT_EQ(open_run(run()).file.state().epoch, 2);
}

TEST_F(TrainingRun, RefusesToGoOnWithAnotherTraining) {
    train(config());
    Config other = config();
    other.train.learning_rate *= 2;
    EXPECT_THROW(train(other, true), UsageError);
    Config others = config();
    others.data.split.step = 4;
    EXPECT_THROW(train(others, true), UsageError);
}

// Which configuration decides, in one place: for --resume and for sweeps.
TEST_F(TrainingRun, ProgressSaysWhatIsLeftToDo) {
    const Config first = config();
    EXPECT_EQ(training_progress(run(), demand(first)), TrainingProgress::none);
    train(first);
    EXPECT_EQ(training_progress(run(), demand(first)), TrainingProgress::finished);
    Config longer = first, shorter = first, filtered = first, faster = first, flatter = first;
    longer.train.epochs = 5;
    shorter.train.epochs = 2;
    filtered.filter.relative_threshold = 0.5;
    faster.train.learning_rate *= 2;
    flatter.train.plateau_epochs = 7;
    EXPECT_EQ(training_progress(run(), demand(longer)), TrainingProgress::begun);
    EXPECT_EQ(training_progress(run(), demand(shorter)), TrainingProgress::none);
    EXPECT_EQ(training_progress(run(), demand(filtered)), TrainingProgress::begun);
    EXPECT_EQ(training_progress(run(), demand(faster)), TrainingProgress::none);
    EXPECT_EQ(training_progress(run(), demand(flatter)), TrainingProgress::none);
    TrainingDemand others = demand(first);
    others.train_shapes = {0, 1};
    EXPECT_EQ(training_progress(run(), others), TrainingProgress::none);
}

TEST_F(TrainingRun, ConfigChangeNamesWhatDiffers) {
    const Config first = config();
    Config filtered = first, flatter = first, other = first;
    filtered.filter.absolute_threshold = 1;
    flatter.train.plateau_gain = 0.5;
    other.own<nn::StackedSettings>().loss.sparsity = 1;
    EXPECT_FALSE(config_change(first, first).filter);
    EXPECT_TRUE(config_change(first, filtered).filter);
    EXPECT_TRUE(config_change(first, filtered).same_result());
    EXPECT_TRUE(config_change(first, flatter).may_go_on());
    EXPECT_FALSE(config_change(first, flatter).same_result());
    EXPECT_FALSE(config_change(first, other).may_go_on());
}

// The same calls for every kind, whatever its codes decode to: training shapes come back nearly,
// codes fitted to the vertices are never farther, and both decode where the codes say.
class EveryKindOfRun : public TrainingRun, public testing::WithParamInterface<std::string> {};

std::vector<std::string> kinds_and_rows() {
    std::vector<std::string> all = kind_names();
    all.emplace_back("units of positions");
    return all;
}

TEST_P(EveryKindOfRun, EncodesDecodesAndFits) {
    const std::string kind = GetParam().substr(0, GetParam().find(' '));
    if (kind == "units") cases::extracted_arm(features_, 30);  // it wants 12 to train on
    Config config = this->config(kind);
    if (GetParam() != kind) config.own<UnitSettings>().rows = ShapeRows::positions;
    train(config);
    TrainedRun opened = open_run(run(), 4);
    const FeatureFile file(features_);
    ShapeDecoder decoder(opened, file, [] {});
    const std::vector<int> shapes{1, 3, 5};
    const std::vector<DecodedShape> encoded = decoder.encode(shapes);
    const std::vector<DecodedShape> fitted = decoder.fit(shapes, encoded);
    for (std::size_t m = 0; m < shapes.size(); ++m) {
        RmsError error(opened.reference().vertices);
        const std::vector<Point> truth = decoder.truth(shapes[m]);
        const double features = error.add(truth, encoded[m].vertices);
        const double vertices = error.add(truth, fitted[m].vertices);
        EXPECT_TRUE(std::isfinite(features));
        EXPECT_LE(vertices, features * (1 + 1e-9)) << "shape " << shapes[m];
        const auto again = decoder.decode(std::span(shapes).subspan(m, 1), {encoded[m].codes});
        EXPECT_EQ(again.front().rows, encoded[m].rows);
    }
}
INSTANTIATE_TEST_SUITE_P(Kinds, EveryKindOfRun, testing::ValuesIn(kinds_and_rows()),
                         [](const auto& kind) {
                             std::string name = kind.param;
                             std::erase(name, '-');
                             std::erase(name, ' ');
                             return name;
                         });

}  // namespace
}  // namespace mscomp
