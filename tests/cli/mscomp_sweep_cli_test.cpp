// SPDX-License-Identifier: MIT
// mscomp sweep as a user runs it: grids and lists, repeated, stopped and changed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/sweep_fixture.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

class Sweep : public SweepFixture {};

const std::vector<std::string> kNames{
    "levels0.components=2_sparsity=10", "levels0.components=2_sparsity=1000",
    "levels0.components=4_sparsity=10", "levels0.components=4_sparsity=1000"};

TEST_F(Sweep, OfAGridHasARowForEachPointInOrder) {
    const Outcome outcome = mscomp("sweep grid.yaml -o out --json --quiet");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    const std::vector<Row> rows = rows_of(file("out/table.csv"));
    EXPECT_EQ(column(rows, "name"), kNames);
    EXPECT_THAT(column(rows, "model.levels[0].components"), ElementsAre("2", "2", "4", "4"));
    EXPECT_THAT(column(rows, "loss.sparsity"), ElementsAre("10", "1000", "10", "1000"));
    EXPECT_THAT(column(rows, "epochs"), ElementsAre("3", "3", "3", "3"));
    EXPECT_EQ(count(file("out/table.md"), "\n"), 2u + 4u);
    EXPECT_EQ(count(file("out/plot.svg"), "class=\"marker\""), 4u);
    EXPECT_EQ(count(file("out/plot.svg"), "<polyline"), 2u);
    const json report = json::parse(outcome.out);
    ASSERT_EQ(report.at("points").size(), 4u);
    EXPECT_EQ(report["points"][2]["name"], kNames[2]);
    EXPECT_EQ(report["points"][2]["settings"]["loss.sparsity"], "10");
}

// A point is what `train` and `evaluate` give for its configuration, bit for bit.
TEST_F(Sweep, IsTrainingAndEvaluatingOneByOne) {
    expect_ok("sweep grid.yaml -o out --quiet");
    write_file(path("one.yaml"),
               "model: {kind: stacked-attention, levels: [{components: 4, sparsity_range: 0.3}]}\n"
               "loss: {sparsity: 10}\n"
               "data: {features: arm.safetensors, split: {train: every, step: 2}}\n"
               "train: {epochs: 3, batch: 3}\n");
    expect_ok("train one.yaml -o one --quiet");
    EXPECT_TRUE(file("one/checkpoint.safetensors") ==
                file("out/" + kNames[2] + "/checkpoint.safetensors"));
    const json report =
        json::parse(mscomp("evaluate one --split test --fit features --json --quiet").out);
    const json kept = json::parse(file("out/" + kNames[2] + "/evaluation.json"));
    EXPECT_EQ(kept.at("evaluation").at("features"), report.at("features"));
    const Row row = rows_of(file("out/table.csv"))[2];
    EXPECT_NEAR(std::stod(row.at("features_rms_error")),
                report.at("features").at("rms_error").get<double>(), 1e-5);
    EXPECT_NEAR(std::stod(row.at("features_relative_squared_error_max")),
                report.at("features").at("relative_squared_error_max").get<double>(), 1e-8);
    EXPECT_NEAR(std::stod(row.at("support_mean_0")),
                report.at("features").at("support_mean").get<double>(), 1e-8);
    EXPECT_EQ(row.at("kept_0"), report.at("components").at(0).dump());
}

TEST_F(Sweep, RepeatedTrainsNothingAndGivesTheSame) {
    expect_ok("sweep grid.yaml -o out --quiet");
    std::map<std::string, fs::file_time_type> before;
    for (const std::string& name : kNames) {
        for (const char* each : {"/checkpoint.safetensors", "/evaluation.json", "/log.txt"}) {
            before[name + each] = time_of("out/" + name + each);
        }
    }
    const std::string table = file("out/table.csv"), plot = file("out/plot.svg");
    const Outcome again = mscomp("sweep grid.yaml -o out");
    EXPECT_EQ(again.code, 0) << again.err;
    for (const auto& [name, time] : before) EXPECT_EQ(time_of("out/" + name), time) << name;
    EXPECT_EQ(file("out/table.csv"), table);
    EXPECT_EQ(file("out/plot.svg"), plot);
    EXPECT_THAT(again.err, HasSubstr("point 4 of 4"));
}

// A point that ended on a plateau, before its last epoch, is finished too.
TEST_F(Sweep, LeavesPlateausAlone) {
    const std::string arguments =
        "sweep grid.yaml -o out --quiet --set train.epochs=50 --set train.plateau_epochs=2 "
        "--set train.plateau_gain=1";
    expect_ok(arguments);
    const std::string table = file("out/table.csv");
    EXPECT_LT(std::stoi(rows_of(table)[0].at("epochs")), 50);
    const auto before = time_of("out/" + kNames[0] + "/log.txt");
    expect_ok(arguments);
    EXPECT_EQ(time_of("out/" + kNames[0] + "/log.txt"), before);
    EXPECT_EQ(file("out/table.csv"), table);
}

// Stopped in its second point and gone on with: the same rows and the same models.
TEST_F(Sweep, StoppedAndRepeatedGivesTheSame) {
    const std::string arguments = "sweep grid.yaml --threads 1 --set train.epochs=400 --quiet -o ";
    expect_ok(arguments + "whole");
    const std::string second = "stopped/" + kNames[1] + "/checkpoint.safetensors";
    const Outcome stopped = shell(folder_, std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments +
                                               "stopped & pid=$!\n"
                                               "until [ -e " +
                                               second +
                                               " ]; do sleep 0.005; done\n"
                                               "kill -INT $pid; wait $pid");
    ASSERT_EQ(stopped.code, 130) << "it ended before it was stopped: " << stopped.err;
    EXPECT_THAT(stopped.err, HasSubstr("point 2 of 4"));
    EXPECT_FALSE(fs::exists(path("stopped/" + kNames[3])));
    EXPECT_EQ(rows_of(file("stopped/table.csv")).size(), 1u);
    expect_ok(arguments + "stopped");
    EXPECT_EQ(results(file("stopped/table.csv")), results(file("whole/table.csv")));
    for (const std::string& name : kNames) {
        EXPECT_TRUE(file("stopped/" + name + "/checkpoint.safetensors") ==
                    file("whole/" + name + "/checkpoint.safetensors"))
            << name;
    }
}

TEST_F(Sweep, TrainsOnlyChangedPointsAnew) {
    const auto listed = [](const std::string& sparsity) {
        return kBase +
               "points:\n  list:\n    - {name: base, set: {}}\n"
               "    - {name: other, set: {loss.sparsity: " +
               sparsity +
               "}}\n"
               "measure: {fit: features}\n";
    };
    write_file(path("list.yaml"), listed("10"));
    expect_ok("sweep list.yaml -o out --quiet");
    const auto base = time_of("out/base/checkpoint.safetensors");
    const std::string other = file("out/other/checkpoint.safetensors");
    write_file(path("list.yaml"), listed("20"));
    expect_ok("sweep list.yaml -o out --quiet");
    EXPECT_EQ(time_of("out/base/checkpoint.safetensors"), base);
    EXPECT_FALSE(file("out/other/checkpoint.safetensors") == other);
    EXPECT_THAT(column(rows_of(file("out/table.csv")), "loss.sparsity"), ElementsAre("1000", "20"));
    expect_ok("sweep list.yaml -o anew --quiet");
    EXPECT_EQ(results(file("out/table.csv")), results(file("anew/table.csv")));
}

// More epochs go on from what is there, fewer begin anew; both end as if asked for at once.
TEST_F(Sweep, FollowsTheNumberOfEpochs) {
    expect_ok("sweep grid.yaml -o out --quiet");
    for (const char* epochs : {"5", "4"}) {
        const std::string set = std::string(" --quiet --set train.epochs=") + epochs;
        expect_ok("sweep grid.yaml -o out" + set);
        expect_ok(std::string("sweep grid.yaml -o anew") + epochs + set);
        EXPECT_EQ(results(file("out/table.csv")),
                  results(file(std::string("anew") + epochs + "/table.csv")));
        const std::string log = file("out/" + kNames[0] + "/log.txt");
        EXPECT_EQ(count(log, "resumed at epoch"), 1u) << log;
    }
}

TEST_F(Sweep, MeasuresAnewWithoutTraining) {
    expect_ok("sweep grid.yaml -o out --quiet");
    const auto before = time_of("out/" + kNames[0] + "/checkpoint.safetensors");
    const auto measure_as = [&](const std::string& wanted) {
        std::string text = kBase + kGrid;
        text.replace(text.find("{fit: features}"), 15, wanted);
        write_file(path("grid.yaml"), text);
        expect_ok("sweep grid.yaml -o out --quiet");
        EXPECT_EQ(time_of("out/" + kNames[0] + "/checkpoint.safetensors"), before);
    };
    measure_as("{fit: features, split: train}");
    const json kept = json::parse(file("out/" + kNames[0] + "/evaluation.json"));
    EXPECT_EQ(kept.at("evaluation").at("split"), "train");
    measure_as("{fit: both, split: train}");
    EXPECT_EQ(rows_of(file("out/table.csv"))[0].count("vertices_rms_error"), 1u);
}

TEST_F(Sweep, TakesEveryEntryOfAListOnTheGrid) {
    write_file(path("kinds.yaml"),
               "base:\n"
               "  data: {features: arm.safetensors, split: {train: every, step: 2}}\n"
               "  train: {epochs: 2}\n"
               "points:\n"
               "  list:\n"
               "    - {name: ae, set: {model.kind: autoencoder}}\n"
               "    - {name: vae, set: {model.kind: spectral-vae, model.filter_order: 2}}\n"
               "  grid: {model.components: [2, 3]}\n"
               "measure: {fit: features}\n");
    expect_ok("sweep kinds.yaml -o out --quiet");
    const std::vector<Row> rows = rows_of(file("out/table.csv"));
    EXPECT_THAT(column(rows, "name"), ElementsAre("ae_components=2", "ae_components=3",
                                                  "vae_components=2", "vae_components=3"));
    EXPECT_THAT(column(rows, "model.kind"),
                ElementsAre("autoencoder", "autoencoder", "spectral-vae", "spectral-vae"));
    EXPECT_THAT(column(rows, "model.filter_order"), ElementsAre("", "", "2", "2"));
    EXPECT_EQ(count(file("out/plot.svg"), "class=\"bar\""), 4u);
}

// Every point holds its value of every key: 2,000 of 100,000 keys would fill any memory.
TEST_F(Sweep, RefusesPointsThatWouldFillTheMemory) {
    std::string keys;
    for (int i = 0; i < 1000; ++i) keys += ", k" + std::to_string(i) + ": [1]";
    std::string values = "1";
    for (int i = 0; i < 1000; ++i) values += ", 1";
    write_file(path("wide.yaml"),
               kBase + "points: {grid: {train.seed: [" + values + "]" + keys + "}}\n");
    const Outcome outcome = mscomp("sweep wide.yaml -o out --quiet");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("1001 points of 1001 keys each, wanted at most 20000"));
}

TEST_F(Sweep, GoesOnPastAPointThatFails) {
    write_file(path("far.yaml"), kBase +
                                     "points: {grid: {train.learning_rate: [1.0e+38, 0.001]}}\n"
                                     "measure: {fit: features}\n");
    const Outcome outcome = mscomp("sweep far.yaml -o out --quiet");
    EXPECT_EQ(outcome.code, 5) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("1 of 2 points failed"));
    EXPECT_THAT(outcome.err, HasSubstr("is not finite"));
    const std::vector<Row> rows = rows_of(file("out/table.csv"));
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_THAT(rows[0].at("failure"), HasSubstr("is not finite"));
    EXPECT_EQ(rows[0].at("features_rms_error"), "");
    EXPECT_EQ(rows[1].at("failure"), "");
    EXPECT_NE(rows[1].at("features_rms_error"), "");
    EXPECT_EQ(count(file("out/plot.svg"), "class=\"bar\""), 1u);
}

}  // namespace
}  // namespace mscomp
