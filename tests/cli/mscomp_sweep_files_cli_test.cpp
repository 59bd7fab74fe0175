// SPDX-License-Identifier: MIT
// What mscomp sweep reads and where it writes: wrong files, file names, folders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "cli/sweep_fixture.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class SweepFiles : public SweepFixture {};

// Names of files count from the file that has them, those of the command line from where it is.
TEST_F(SweepFiles, FindsFilesFromWhereTheyAreNamed) {
    fs::create_directories(path("a/b"));
    write_file(path("a/base.yaml"),
               "model: {kind: stacked-attention, levels: [{components: 2, sparsity_range: 0.3}]}\n"
               "data: {features: ../arm.safetensors, split: {train: every, step: 2}}\n"
               "train: {epochs: 1}\n");
    write_file(path("a/b/s.yaml"),
               "config: ../base.yaml\npoints: {grid: {train.seed: [0]}}\n"
               "measure: {fit: features}\n");
    expect_ok("sweep a/b/s.yaml -o one --quiet");
    write_file(path("train.txt"), "0\n1\n2\n");
    expect_ok(
        "sweep a/b/s.yaml -o two --quiet --set data.features=arm.safetensors "
        "--set 'data.split={train: file, path: train.txt}'");
    EXPECT_EQ(json::parse(mscomp("info two/seed=0 --json").out).at("train_shapes"), 3);
}

// The configuration is the same, what it names is not: another list of shapes, other features.
TEST_F(SweepFiles, TrainsAnewWhereWhatTheFilesHoldIsAnother) {
    write_file(path("train.txt"), "0\n1\n2\n");
    write_file(path("s.yaml"), kBase +
                                   "points: {grid: {train.seed: [0]}}\n"
                                   "measure: {fit: features}\n");
    const std::string arguments =
        "sweep s.yaml -o out --quiet --set 'data.split={train: file, path: train.txt}'";
    expect_ok(arguments);
    write_file(path("train.txt"), "0\n1\n2\n3\n");
    expect_ok(arguments);
    EXPECT_EQ(json::parse(mscomp("info out/seed=0 --json").out).at("train_shapes"), 4);

    const std::string before = file("out/seed=0/checkpoint.safetensors");
    fs::remove(path("arm.safetensors"));
    const Outcome other = shell(folder_, std::string(MSCOMP_BIN_DIR) + "/acapfeat extract '" +
                                             fs::path(arm_features()).parent_path().string() +
                                             "/m' --weights uniform -o arm.safetensors --quiet");
    ASSERT_EQ(other.code, 0) << other.err;
    expect_ok(arguments);
    EXPECT_FALSE(file("out/seed=0/checkpoint.safetensors") == before);
}

struct WrongFile {
    std::string text;   // behind the base
    std::string place;  // line and column
    std::string says;
};

// Nothing is written, and the message has the place and what is wanted.
TEST_F(SweepFiles, RefusesWrongFilesBeforeAnythingIsWritten) {
    const std::vector<WrongFile> wrong{
        {"point: {grid: {train.seed: [0]}}\n", ":5:1", "points"},
        {"points: {grids: {train.seed: [0]}}\n", ":5:10", "grid"},
        {"points:\n  grid:\n    train.epoch: [1]\n", ":7:5", "train.epochs"},
        {"points:\n  grid:\n    train.epochs: [1, many]\n", ":7:23", "a whole number"},
        {"points:\n  grid:\n    train.epochs: 3\n", ":7:19", "a list of values"},
        {"points:\n  grid:\n    model.levels[1].components: [3]\n", ":7:5", "no such level"},
        {"points:\n  grid:\n    model.filter_order: [3]\n", ":7:5", "spectral-vae"},
        {"points:\n  list:\n    - {name: a/b, set: {train.seed: 1}}\n", ":7:14", "letters"},
        {"points:\n  list:\n    - {name: a, sets: {train.seed: 1}}\n", ":7:17", "set"},
        {"points:\n  list:\n    - {name: a}\n    - {name: a}\n", ":8:7", "two points"},
        {"points:\n  list:\n    - {name: a, set: {train.seed: 1}}\n  grid: {train.seed: [2]}\n",
         ":8:10", "given twice"},
        {"points: {grid: {train.seed: [0]}}\nmeasure: {split: tests}\n", ":6:18", "test"},
        {"points: {grid: {train.seed: [0]}}\nplot: {x: train.sed}\n", ":6:11", "train.seed"},
        {"points: {grid: {train.seed: [0]}}\nplot: {y: rms}\n", ":6:11", "rms_error"},
        {"points: {grid: {train.seed: [0]}}\nconfig: base.yaml\n", ":6:1", "either"},
        {"points: {grid: {train.seed: [0]}}\npoints: {}\n", ":6:1", "given twice"},
        {"points: {grid: {train.seed: [0]}\n", "", "not valid YAML"},
        {"", "", "points"}};
    for (const auto& [text, place, says] : wrong) {
        write_file(path("wrong.yaml"), kBase + text);
        const Outcome outcome = mscomp("sweep wrong.yaml -o out");
        EXPECT_EQ(outcome.code, 2) << text << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("wrong.yaml" + place)) << text;
        EXPECT_THAT(outcome.err, HasSubstr(says)) << text;
        EXPECT_FALSE(fs::exists(path("out"))) << text;
    }
}

TEST_F(SweepFiles, RefusesAnOverrideOfWhatThePointsSet) {
    const Outcome outcome = mscomp("sweep grid.yaml -o out --set loss.sparsity=3");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("loss.sparsity"));
    EXPECT_FALSE(fs::exists(path("out")));
}

TEST_F(SweepFiles, RefusesASplitThatLeavesNothingToMeasure) {
    const Outcome outcome = mscomp("sweep grid.yaml -o out --set data.split.train=all");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("all 8 shapes train"));
    EXPECT_FALSE(fs::exists(path("out")));
}

TEST_F(SweepFiles, RefusesAFolderOfSomethingElse) {
    fs::create_directories(path("out"));
    write_file(path("out/mine.txt"), "mine");
    const Outcome outcome = mscomp("sweep grid.yaml -o out");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("--force"));
    EXPECT_FALSE(fs::exists(path("out/table.csv")));
}

// A value that is no folder name still names one folder, another one than its like, and always the
// same one.
TEST_F(SweepFiles, NamesFoldersSafely) {
    write_file(
        path("names.yaml"),
        "base: {model: {kind: autoencoder}, data: {features: arm.safetensors, split: {train: "
        "every, step: 2}}, train: {epochs: 1}}\n"
        "points: {grid: {model.sparsity_ramp: [[0.1, 0.2], [0.1, 0.3], null]}}\n"
        "measure: {fit: features}\n");
    expect_ok("sweep names.yaml -o out --quiet --set model.components=2");
    std::set<std::string> folders;
    for (const auto& entry : fs::directory_iterator(path("out"))) {
        if (entry.is_directory()) folders.insert(entry.path().filename().string());
    }
    EXPECT_EQ(folders.size(), 3u);
    EXPECT_TRUE(folders.contains("sparsity_ramp=null"));
    for (const std::string& name : folders) {
        EXPECT_EQ(name.find_first_of("/[], "), std::string::npos) << name;
    }
}

// Every ablation that comes with the project is a sweep of configurations that are in order: it
// gets as far as looking for the features.
TEST_F(SweepFiles, AblationsAreSound) {
    int files = 0;
    for (const auto& entry :
         fs::directory_iterator(fs::path(MSCOMP_TESTS_DIR).parent_path() / "data/ablations")) {
        if (entry.path().extension() != ".yaml") continue;
        ++files;
        const Outcome outcome = mscomp("sweep " + entry.path().string() +
                                       " -o out --set data.features=nowhere.safetensors");
        EXPECT_EQ(outcome.code, 4) << entry.path() << ": " << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("nowhere.safetensors"));
    }
    EXPECT_GE(files, 9);
}

}  // namespace
}  // namespace mscomp
