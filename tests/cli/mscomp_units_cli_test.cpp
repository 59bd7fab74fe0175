// SPDX-License-Identifier: MIT
// mscomp units: from features, and from another run, by the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/temporary_folder.h"
#include "cli/sweep_fixture.h"

namespace mscomp {
namespace {

using testing::HasSubstr;

class UnitsCommand : public testing::Test {
  protected:
    UnitsCommand() {
        std::filesystem::create_directories(work_);
        run("acapfeat generate arm -o arm --frames 60 --vertices 300 --quiet", 0);
        run("acapfeat extract arm -o arm.safetensors --quiet", 0);
    }
    Outcome run(const std::string& arguments, int code) const {
        const Outcome outcome = shell(work_, std::string(MSCOMP_BIN_DIR) + "/" + arguments);
        EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.err;
        return outcome;
    }
    nlohmann::json json_of(const std::string& arguments) const {
        return nlohmann::json::parse(run(arguments + " --json", 0).out);
    }
    std::string content(const std::string& name) const {
        return TemporaryFolder::content(work_ + "/" + name);
    }

    TemporaryFolder temporary_;
    std::string work_ = temporary_ / "work";
};

// A run like any other, whose configuration finds the same again; every unit says how sure it is.
TEST_F(UnitsCommand, MakesARunLikeAnyOther) {
    EXPECT_THAT(run("mscomp units arm.safetensors -o u.run --quiet", 0).out,
                HasSubstr("u.run: 1 epochs, 1 steps, loss "));
    EXPECT_THAT(content("u.run/log.txt"), HasSubstr("mscomp units arm.safetensors"));
    EXPECT_THAT(content("u.run/log.txt"), HasSubstr("units: "));
    EXPECT_EQ(json_of("mscomp info u.run").at("kind"), "units");
    const auto report = json_of("mscomp evaluate u.run --quiet");
    ASSERT_FALSE(report.at("component_list").empty());
    for (const auto& component : report.at("component_list")) {
        EXPECT_GE(component.at("votes"), 2);
        EXPECT_GE(component.at("found_again"), 0);
        EXPECT_LE(component.at("found_again"), 1);
    }
    EXPECT_THAT(run("mscomp evaluate u.run --quiet", 0).out,
                HasSubstr("found again in subsets of the training shapes: "));
    run("mscomp export-components u.run -o parts --tile 64 --quiet", 0);
    const auto listed = nlohmann::json::parse(content("parts/components.json")).at("components");
    for (const auto& component : listed) {
        EXPECT_THAT(component.at("acts"), testing::AnyOf("turns", "stretches", "both"));
        EXPECT_TRUE(component.contains("side"));
        EXPECT_TRUE(component.contains("mirror_partner"));
    }
    run("mscomp synthesize u.run --weight 0=1 -o one.obj --quiet", 0);
    run("mscomp train u.run/config.yaml -o again.run --threads 1 --quiet", 0);
    EXPECT_EQ(content("again.run/checkpoint.safetensors"), content("u.run/checkpoint.safetensors"));
}

TEST_F(UnitsCommand, TurnsTheComponentsOfARunIntoUnits) {
    run("mscomp init autoencoder > a.yaml", 0);
    run("mscomp train a.yaml -o a.run --quiet --set data.features=arm.safetensors "
        "--set model.components=12 --set train.epochs=60",
        0);
    run("mscomp units a.run -o u.run --quiet", 0);
    EXPECT_THAT(content("u.run/config.yaml"), HasSubstr("a.run"));
    EXPECT_THAT(content("u.run/log.txt"), HasSubstr("begins with the 12 components of "));
    EXPECT_GT(json_of("mscomp evaluate u.run --quiet").at("component_list").size(), 0U);
}

// The same commands, the same lists; a run of positions gives units of positions.
TEST_F(UnitsCommand, FindsThemInPositions) {
    run("mscomp units arm.safetensors -o u.run --positions --quiet", 0);
    EXPECT_THAT(content("u.run/config.yaml"), HasSubstr("rows: positions"));
    const auto report = json_of("mscomp evaluate u.run --split all --fit both --quiet");
    ASSERT_FALSE(report.at("component_list").empty());
    for (const auto& component : report.at("component_list")) {
        EXPECT_TRUE(component.at("kept"));
        EXPECT_GE(component.at("votes"), 2);
    }
    EXPECT_LE(report.at("vertices").at("rms_error").get<double>(),
              report.at("features").at("rms_error").get<double>() * (1 + 1e-9));
    run("mscomp export-components u.run -o parts --tile 64 --quiet", 0);
    const auto listed = nlohmann::json::parse(content("parts/components.json")).at("components");
    EXPECT_EQ(listed.size(), report.at("component_list").size());
    for (const auto& component : listed) EXPECT_TRUE(component.contains("side"));
    run("mscomp synthesize u.run --weight 0=1 -o one.obj --quiet", 0);
    run("mscomp reconstruct u.run arm.safetensors -o decoded --quiet", 0);
    run("mscomp train u.run/config.yaml -o again.run --threads 1 --quiet", 0);
    EXPECT_EQ(content("again.run/checkpoint.safetensors"), content("u.run/checkpoint.safetensors"));

    run("mscomp init pca > p.yaml", 0);
    run("mscomp train p.yaml -o p.run --quiet --set data.features=arm.safetensors", 0);
    run("mscomp units p.run -o v.run --quiet", 0);
    EXPECT_THAT(content("v.run/config.yaml"), HasSubstr("rows: positions"));
    EXPECT_THAT(content("v.run/config.yaml"), HasSubstr("minimum_strength: 0 "));
    EXPECT_THAT(run("mscomp units u.run -o w.run --set model.rows=features", 2).err,
                HasSubstr("changes of positions; wanted changes of features"));
}

TEST_F(UnitsCommand, AtMostSoMany) {
    run("mscomp units arm.safetensors -o u.run --components 3 --quiet", 0);
    EXPECT_EQ(json_of("mscomp evaluate u.run --quiet").at("component_list").size(), 3U);
    EXPECT_THAT(run("mscomp units arm.safetensors -o v.run --components 0", 2).err,
                HasSubstr("--components"));
}

// Nobody says that an arm is made of joints; its true movers are found, at most four more, where
// they lie, and what moves much of the mesh, joints, is level 0, bulges and ripples are level 1.
TEST_F(UnitsCommand, FindsTheJointsOfAnArm) {
    run("acapfeat generate arm -o whole --quiet", 0);
    run("acapfeat extract whole -o whole.safetensors --quiet", 0);
    run("mscomp units whole.safetensors -o joints.run --quiet", 0);
    const auto report =
        json_of("mscomp evaluate joints.run --split all --fit features --truth whole/truth.json");
    EXPECT_LE(report["component_list"].size(), 16U);
    EXPECT_GE(report["truth"]["features"]["matched_one_to_one"].get<int>(), 11);
    int read = 0;
    for (const auto& component : report["component_list"]) {
        read += component["held_out"].get<double>() > 0.9 ? 1 : 0;
    }
    EXPECT_GE(read, 8) << "of the joints in shapes that were left out";
    for (const std::string scale : {"coarse", "fine"}) {
        const auto& found = report["truth"]["by_overlap"][scale];
        EXPECT_GE(found["iou"].get<double>(), 0.55) << scale;
        EXPECT_EQ(found["at_scale"], found["components"]) << scale;
    }
}

// A search that has ended is not done once more, one that left nothing begins anew, and another
// configuration is no way to go on.
TEST_F(UnitsCommand, GoesOn) {
    run("mscomp units arm.safetensors -o u.run --quiet", 0);
    const std::string found = content("u.run/checkpoint.safetensors");
    const auto written = std::filesystem::last_write_time(work_ + "/u.run/checkpoint.safetensors");
    run("mscomp units arm.safetensors -o u.run --quiet --resume", 0);
    EXPECT_EQ(content("u.run/checkpoint.safetensors"), found);
    EXPECT_EQ(std::filesystem::last_write_time(work_ + "/u.run/checkpoint.safetensors"), written);
    std::filesystem::remove(work_ + "/u.run/checkpoint.safetensors");
    std::filesystem::remove(work_ + "/u.run/metrics.csv");
    run("mscomp units arm.safetensors -o u.run --quiet --resume", 0);
    EXPECT_EQ(content("u.run/checkpoint.safetensors"), found);
    EXPECT_THAT(run("mscomp units arm.safetensors -o u.run --quiet --resume --components 3", 2).err,
                HasSubstr("was trained with another configuration"));
    EXPECT_THAT(run("mscomp units arm.safetensors -o u.run --quiet", 2).err, HasSubstr("--force"));
    // Nor is another input.
    run("acapfeat generate arm -o other --frames 20 --vertices 300 --quiet", 0);
    run("acapfeat extract other -o other.safetensors --quiet", 0);
    run("mscomp units other.safetensors -o u.run --quiet --resume", 2);
    run("mscomp units nothing.safetensors -o u.run --quiet --resume", 4);
}

// A search that takes long is stopped at once, and begins anew.
TEST_F(UnitsCommand, IsStoppedInTheMiddle) {
    const std::string units = std::string(MSCOMP_BIN_DIR) + "/mscomp units arm.safetensors -o ";
    run("mscomp units arm.safetensors -o whole.run --quiet", 0);
    const Outcome stopped =
        shell(work_, units +
                         "u.run --threads 1 & pid=$!; "
                         "while ! [ -e u.run/log.txt ]; do sleep 0.01; done; sleep 0.2; "
                         "kill -INT $pid; wait $pid");
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_THAT(stopped.err, HasSubstr("the same command begins anew"));
    EXPECT_FALSE(std::filesystem::exists(work_ + "/u.run/checkpoint.safetensors"));
    run("mscomp units arm.safetensors -o u.run --quiet --resume", 0);
    EXPECT_EQ(content("u.run/checkpoint.safetensors"), content("whole.run/checkpoint.safetensors"));
}

TEST_F(UnitsCommand, SaysWhatCannotBe) {
    EXPECT_THAT(run("mscomp units arm.safetensors -o u.run --quiet --set "
                    "'data.split={train: every, step: 20}'",
                    2)
                    .err,
                HasSubstr("3 training shapes, wanted 12 at least to find units in"));
    run("mscomp init pca > p.yaml", 0);
    run("mscomp train p.yaml -o p.run --quiet --set data.features=arm.safetensors "
        "--set model.components=3",
        0);
    EXPECT_THAT(run("mscomp units p.run -o u.run --set model.rows=features", 2).err,
                HasSubstr("changes of positions; wanted changes of features"));
    EXPECT_THAT(run("mscomp refine p.run -o r.run", 2).err,
                HasSubstr("changes of positions; wanted changes of features"));
    EXPECT_THAT(run("mscomp units nothing.safetensors -o u.run", 4).err,
                HasSubstr("nothing.safetensors"));
    // Joints as what switches: the whole arm follows.
    EXPECT_THAT(run("mscomp units arm.safetensors -o w.run --set model.route=codes", 0).err,
                HasSubstr("of the mesh on average: joints"));
    // Each shape moves in a way of its own: what is found is none, and that is said.
    run("acapfeat generate twist -o twist --frames 30 --noise 0.3 --quiet", 0);
    run("acapfeat extract twist -o twist.safetensors --quiet", 0);
    EXPECT_THAT(
        shell(work_, std::string(MSCOMP_BIN_DIR) + "/mscomp units twist.safetensors -o t.run").err,
        testing::AnyOf(HasSubstr("What is found may be none"), HasSubstr("agree on a unit")));
}

}  // namespace
}  // namespace mscomp
