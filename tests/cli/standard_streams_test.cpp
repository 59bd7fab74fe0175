// SPDX-License-Identifier: MIT
// Whatever becomes of standard input, output and error, a command does its work and says how it
// went.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "cli/small_run.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class StandardStreams : public CopiedRun {
  protected:
    bool is_made(const Command& command) const {
        return command.output.empty() || fs::exists(folder_ / command.output);
    }
    void forget(const Command& command) const {
        if (!command.output.empty()) {
            fs::remove_all(folder_ / command.output.substr(0, command.output.find('/')));
        }
    }
    /// Every command ends as ever and leaves what it makes.
    void expect_work_done(int err, const char* what) const {
        for (const Command& command : working_commands()) {
            Start start = start_of(command.words);
            start.err = err;
            const Stream out = Stream::of_file("/dev/null");
            start.out = out.number();
            EXPECT_EQ(exit_code_of(start), 0) << what << ": " << text_of(command.words);
            EXPECT_TRUE(is_made(command)) << what << ": " << text_of(command.words);
            forget(command);
        }
    }
};

TEST_F(StandardStreams, AFullErrorStreamChangesNothing) {
    expect_work_done(Stream::of_file("/dev/full").number(), "full");
}

TEST_F(StandardStreams, AClosedErrorStreamChangesNothing) { expect_work_done(-1, "closed"); }

TEST_F(StandardStreams, AnErrorStreamThatNobodyReadsChangesNothing) {
    const Stream err = Stream::without_reader();
    expect_work_done(err.number(), "without a reader");
}

TEST_F(StandardStreams, ATerminalThatHungUpChangesNothing) {
    const Stream err = Stream::hung_up_terminal();
    expect_work_done(err.number(), "hung up");
}

TEST_F(StandardStreams, AnErrorKeepsItsCodeWhereNobodyReadsIt) {
    const Stream full = Stream::of_file("/dev/full"), alone = Stream::without_reader();
    for (const int err : {-1, full.number(), alone.number()}) {
        for (const auto& [words, code] : std::vector<std::pair<std::vector<std::string>, int>>{
                 {{"acapfeat", "extract", "nowhere", "-o", "x.safetensors"}, 2},
                 {{"acapfeat", "--wrong"}, 2},
                 {{"acapfeat", "info", "handles.json"}, 3},
                 {{"acapfeat", "info", "nowhere.safetensors"}, 4},
                 {{"mscomp", "info", "f.safetensors"}, 6}}) {
            Start start = start_of(words);
            start.err = err;
            EXPECT_EQ(exit_code_of(start), code) << text_of(words);
        }
    }
}

// Results that are lost must not look like success, and files are written all the same.
TEST_F(StandardStreams, ResultsThatCannotBeWrittenAreFour) {
    const Stream full = Stream::of_file("/dev/full"), alone = Stream::without_reader();
    for (const int out : {-1, full.number(), alone.number()}) {
        for (const Command& command : working_commands()) {
            const Stream err = Stream::of_file(folder_ / "err");
            Start start = start_of(command.words);
            start.out = out;
            start.err = err.number();
            EXPECT_EQ(exit_code_of(start), 4) << out << ": " << text_of(command.words);
            EXPECT_TRUE(is_made(command)) << text_of(command.words);
            EXPECT_THAT(TemporaryFolder::content(folder_ / "err"),
                        HasSubstr("error: standard output: "))
                << text_of(command.words);
            forget(command);
            fs::remove(folder_ / "err");
        }
        for (const char* question : {"--help", "--version"}) {
            Start start = start_of({"mscomp", question});
            start.out = out;
            start.err = full.number();
            EXPECT_EQ(exit_code_of(start), 4) << question;
        }
    }
}

// The first file that a process opens has the lowest number that is free.
TEST_F(StandardStreams, NoFileTakesThePlaceOfAClosedStream) {
    Start start = start_of({"acapfeat", "extract", "meshes", "-o", "g.safetensors"});
    start.in = start.out = start.err = -1;
    EXPECT_EQ(exit_code_of(start), 4);
    EXPECT_EQ(TemporaryFolder::content(folder_ / "g.safetensors"),
              TemporaryFolder::content(folder_ / "f.safetensors"));
}

// As `2>&1 | head -1` has it.
TEST_F(StandardStreams, ATrainingOutlivesTheReaderOfItsProgress) {
    ASSERT_EQ(run({"mscomp", "train", "c.yaml", "-o", "quiet.run"}).code, 0);
    const Stream gone = Stream::without_reader();
    Start start = start_of({"mscomp", "train", "c.yaml", "-o", "again.run"});
    start.out = start.err = gone.number();
    EXPECT_EQ(exit_code_of(start), 4);
    EXPECT_EQ(TemporaryFolder::content(folder_ / "again.run/checkpoint.safetensors"),
              TemporaryFolder::content(folder_ / "quiet.run/checkpoint.safetensors"));
}

TEST_F(StandardStreams, AFileThatMayNotGrowIsAFullDisk) {
    Start start = start_of({"acapfeat", "extract", "meshes", "-o", "g.safetensors"});
    start.file_size = 4096;
    const Outcome outcome = run(start);
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("g.safetensors: cannot write: File too large"));
    EXPECT_FALSE(fs::exists(folder_ / "g.safetensors"));
}

}  // namespace
}  // namespace mscomp
