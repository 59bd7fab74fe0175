// SPDX-License-Identifier: MIT
// A run folder under several processes, signals and kills.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/temporary_folder.h"
#include "cli/sweep_fixture.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RunFolder : public testing::Test {
  protected:
    RunFolder() {
        fs::create_directories(work_);
        temporary_.put("work/config.yaml",
                       fmt::format("model: {{kind: stacked-attention, levels: [{{components: 2, "
                                   "sparsity_range: 0.3}}]}}\n"
                                   "data: {{features: {}}}\n"
                                   "train: {{epochs: 3, checkpoint_every: 100000}}\n",
                                   arm_features()));
    }
    Outcome train(const std::string& arguments) const {
        return shell(work_, mscomp_ + "train config.yaml -o run --quiet " + arguments);
    }
    /// A training without end, `meanwhile` once it has begun, and how it ended.
    Outcome train_while(const std::string& meanwhile, const std::string& prefix = "") const {
        return shell(work_, prefix + mscomp_ +
                                "train config.yaml -o run --quiet --set train.epochs=1000000 "
                                "--set train.plateau_epochs=0 & "
                                "pid=$!\n"
                                "until [ -e run/checkpoint.safetensors ]; do sleep 0.01; done\n" +
                                meanwhile + "\nwait $pid");
    }
    int epochs() const {
        const Outcome info = shell(work_, mscomp_ + "info run --json");
        return nlohmann::json::parse(info.out).at("epochs");
    }
    std::string put(const std::string& name) const {
        return temporary_.put("work/" + name, "mine");
    }
    std::string content(const std::string& name) const {
        return TemporaryFolder::content(work_ + "/" + name);
    }

    TemporaryFolder temporary_;
    std::string work_ = temporary_ / "work";
    std::string mscomp_ = std::string(MSCOMP_BIN_DIR) + "/mscomp ";
};

TEST_F(RunFolder, WithoutACheckpointResumeStarts) {
    for (const char* before : {"true", "mkdir run", "mkdir run; touch run/notes.txt",
                               "mkdir -p run/.mscomp1-0; touch run/.lock run/log.txt"}) {
        shell(work_, std::string("rm -rf run; ") + before);
        const Outcome outcome = train("--resume");
        EXPECT_EQ(outcome.code, 0) << before << outcome.err;
        EXPECT_EQ(epochs(), 3);
    }
    shell(work_, "rm -rf run; mkdir run");
    put("run/config.yaml");
    EXPECT_EQ(train("--resume").code, 2);
    EXPECT_EQ(content("run/config.yaml"), "mine");
}

// Killed before it saved for the first time: the same command, without --force.
TEST_F(RunFolder, LeftByAKillBeforeTheFirstSaveIsFree) {
    shell(work_, "mkdir -p run/.mscomp1-0/new; touch run/.lock run/log.txt run/.mscomp1-0/new/a");
    const Outcome outcome = train("");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_FALSE(fs::exists(work_ + "/run/.mscomp1-0"));
    EXPECT_EQ(train("").code, 2);
}

TEST_F(RunFolder, IsRefusedToASecondProcessAtOnceAndReadMeanwhile) {
    const Outcome outcome = train_while(
        "cp run/checkpoint.safetensors before\n"
        "for o in --force --resume; do timeout 1 " +
        mscomp_ +
        "train config.yaml -o run --quiet $o; echo $?; done\n"
        "cmp before run/checkpoint.safetensors && " +
        mscomp_ + "info run >info && echo read; kill -INT $pid");
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_EQ(outcome.out, "4\n4\nread\n");
    EXPECT_THAT(outcome.err, HasSubstr("run: process "));
    EXPECT_EQ(train("--resume --set train.epochs=1000000 --set train.plateau_epochs=1").code, 0);
}

TEST_F(RunFolder, IsSavedOnEverySignalThatAnnouncesAnEnd) {
    for (const int signal : {SIGHUP, SIGTERM, SIGUSR2, SIGXCPU}) {
        const Outcome outcome =
            train_while(fmt::format("sleep 0.1; kill -{} $pid", signal), "rm -rf run; ");
        EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("--resume"));
        EXPECT_GT(epochs(), 0);
    }
}

TEST_F(RunFolder, IsSavedAndGoneOnWithOnUsr1) {
    const Outcome outcome = train_while(
        "sleep 0.1; cp run/checkpoint.safetensors before; kill -USR1 $pid\n"
        "while cmp -s before run/checkpoint.safetensors; do sleep 0.01; done\n"
        "kill -0 $pid && echo on; kill -KILL $pid");
    EXPECT_EQ(outcome.out, "on\n");
    EXPECT_GT(epochs(), 0);
}

TEST_F(RunFolder, UnderNohupGoesOnWhenTheTerminalIsClosed) {
    const Outcome outcome = train_while(
        "kill -HUP $pid; sleep 0.3; kill -0 $pid && echo on; kill -INT $pid", "trap '' HUP; ");
    EXPECT_EQ(outcome.out, "on\n");
    EXPECT_EQ(outcome.code, 130);
}

// A file that grows beyond the limit raises a signal that would end the process with its temporary.
TEST_F(RunFolder, ALimitOfTheFileSizeIsAMessageAndLeavesNothing) {
    const Outcome outcome =
        shell(work_, "ulimit -f 8; exec " + mscomp_ + "train config.yaml -o run --quiet");
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("run/checkpoint.safetensors: "));
    EXPECT_EQ(train("").code, 0);
}

}  // namespace
}  // namespace mscomp
