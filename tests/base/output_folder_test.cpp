// SPDX-License-Identifier: MIT
#include "mscomp/base/output_folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "base/full_disk.h"
#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/outputs.h"

namespace fs = std::filesystem;

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// "name content" of every entry, sorted; folders are "name/".
std::vector<std::string> contents(const std::string& folder) {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        all.push_back(entry.is_directory()
                          ? name + "/"
                          : name + " " + TemporaryFolder::content(entry.path().string()));
    }
    std::sort(all.begin(), all.end());
    return all;
}

void write_new(const OutputFolder& output) {
    write_file(output.path("a"), "new");
    write_file(output.path("b"), "new");
}

/// Does `work`, which kills itself, in another process.
void do_and_die(const std::function<void()>& work) {
    const pid_t child = ::fork();
    if (child == 0) {
        work();
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));
}

class OutputFolders : public testing::Test {
  protected:
    TemporaryFolder place_;
    std::string folder_ = place_ / "out";
};

TEST_F(OutputFolders, AppearWholeOrNotAtAll) {
    {
        OutputFolder output(folder_);
        write_new(output);
        EXPECT_FALSE(fs::exists(folder_));
    }
    EXPECT_THAT(place_.names(), IsEmpty());
    {
        OutputFolder output(folder_);
        write_new(output);
        output.commit();
        EXPECT_THAT(contents(folder_), ElementsAre("a new", "b new"));
    }
    EXPECT_THAT(place_.names(), ElementsAre("out"));
}

TEST_F(OutputFolders, KeepWhatIsNotTheirsAndDropWhatIsAskedFor) {
    for (const char* name : {"a", "c", "mine"}) place_.put(std::string("out/") + name, "old");
    ASSERT_EQ(::chmod(folder_.c_str(), 0750), 0);
    OutputFolder output(folder_);
    output.drop("a");
    output.drop("c");
    write_new(output);
    EXPECT_THAT(contents(folder_), ElementsAre("a old", "c old", "mine old"));
    output.commit();
    EXPECT_THAT(contents(folder_), ElementsAre("a new", "b new", "mine old"));
    EXPECT_EQ(fs::status(folder_).permissions(), fs::perms{0750});
}

// In one step: nobody sees some of the new files among the old ones.
TEST_F(OutputFolders, AreExchangedInOneStep) {
    place_.put("out/a", "old");
    const int earlier = ::open(folder_.c_str(), O_RDONLY | O_DIRECTORY);
    struct stat before {
    }, after{};
    ::fstat(earlier, &before);
    ::close(earlier);
    OutputFolder output(folder_);
    write_new(output);
    output.commit();
    ::stat(folder_.c_str(), &after);
    EXPECT_NE(before.st_ino, after.st_ino);
}

// With folders in it, or where we stand in it, the folder stays itself.
TEST_F(OutputFolders, ThatHoldFoldersOrAreTheCurrentOneStay) {
    place_.put("out/a", "old");
    place_.put("out/sub/mine", "old");
    {
        OutputFolder output(folder_);
        write_new(output);
        output.commit();
    }
    EXPECT_THAT(contents(folder_), ElementsAre("a new", "b new", "sub/"));
    EXPECT_EQ(TemporaryFolder::content(folder_ + "/sub/mine"), "old");

    const fs::path here = fs::current_path();
    fs::remove_all(folder_ + "/sub");
    fs::current_path(folder_);
    OutputFolder output(".");
    write_file(output.path("c"), "new");
    output.commit();
    EXPECT_THAT(contents("."), ElementsAre("a new", "b new", "c new"));
    fs::current_path(here);
}

TEST_F(OutputFolders, BehindALinkAreReplacedThere) {
    place_.put("real/a", "old");
    fs::create_directory_symlink("real", place_ / "out");
    OutputFolder output(folder_);
    write_new(output);
    output.commit();
    EXPECT_TRUE(fs::is_symlink(folder_));
    EXPECT_THAT(contents(place_ / "real"), ElementsAre("a new", "b new"));
}

TEST_F(OutputFolders, WhatFailsNamesTheFinalFileAndChangesNothing) {
    place_.put("out/a", "old");
    std::string message;
    {
        OutputFolder output(folder_);
        const FullDisk full(1 << 10);
        message = thrown_message<IoError>(
            [&] { write_file(output.path("a"), std::string(1 << 20, 'x')); });
    }
    EXPECT_THAT(message, testing::StartsWith(folder_ + "/a: "));
    EXPECT_THAT(contents(folder_), ElementsAre("a old"));
    EXPECT_THAT(place_.names(), ElementsAre("out"));
}

TEST_F(OutputFolders, WillNotReplaceAFolderByAFile) {
    fs::create_directories(folder_ + "/a");
    OutputFolder output(folder_);
    EXPECT_THROW(output.path("a"), IoError);
}

// Two at a time into one folder, each with files of its own: both are there afterwards.
TEST_F(OutputFolders, OfTwoProcessesKeepTheFilesOfBoth) {
    place_.put("out/mine", "old");
    OutputFolder one(folder_), other(folder_);
    write_file(one.path("one"), "new");
    write_file(other.path("other"), "new");
    one.commit();
    other.commit();
    EXPECT_THAT(contents(folder_), ElementsAre("mine old", "one new", "other new"));
}

TEST_F(OutputFolders, OfAKilledProcessAreRemovedByTheNextAndThoseOfALivingOneAreNot) {
    do_and_die([&] {
        OutputFolder output(folder_);
        write_new(output);
        ::raise(SIGKILL);
    });
    EXPECT_EQ(place_.names().size(), 1u);
    {
        OutputFolder living(folder_);
        write_new(living);
        EXPECT_EQ(place_.names().size(), 1u);
        {
            const OutputFolder output(folder_);
            EXPECT_EQ(place_.names().size(), 2u);
        }
        living.commit();
    }
    EXPECT_THAT(place_.names(), ElementsAre("out"));
}

class OutputFilesTest : public OutputFolders {};

TEST_F(OutputFilesTest, AppearTogetherOrNotAtAll) {
    place_.put("a", "old");
    const std::string a = place_ / "a", b = place_ / "b";
    {
        OutputFiles files({a, b});
        write_file(files.path(a), "new");
        write_file(files.path(b), "new");
    }
    EXPECT_THAT(contents(place_.path()), ElementsAre("a old"));
    {
        OutputFiles files({a, b});
        write_file(files.path(a), "new");
        write_file(files.path(b), "new");
        files.commit();
    }
    EXPECT_THAT(contents(place_.path()), ElementsAre("a new", "b new"));
}

TEST_F(OutputFilesTest, KeepModesAndLinks) {
    place_.put("sub/a", "old");
    ASSERT_EQ(::chmod((place_ / "sub/a").c_str(), 0640), 0);
    fs::create_symlink("sub/a", place_ / "a");
    const std::string a = place_ / "a", b = place_ / "b";
    {
        OutputFiles files({a, b});
        write_file(files.path(a), "new");
        write_file(files.path(b), "new");
        files.commit();
    }
    EXPECT_TRUE(fs::is_symlink(a));
    EXPECT_EQ(TemporaryFolder::content(a), "new");
    EXPECT_EQ(fs::status(a).permissions(), fs::perms{0640});
}

TEST_F(OutputFilesTest, WillNotReplaceAFolderThatCameMeanwhile) {
    place_.put("a", "old");
    const std::string a = place_ / "a", b = place_ / "b";
    {
        OutputFiles files({a, b});
        write_file(files.path(a), "new");
        write_file(files.path(b), "new");
        place_.put("b/full", "mine");
        EXPECT_THROW(files.commit(), IoError);
    }
    EXPECT_THAT(contents(place_.path()), ElementsAre("a old", "b/"));
}

// As a process leaves it that is killed after the first of two files was moved.
TEST_F(OutputFilesTest, HalfMovedByAKilledProcessAreUndoneByTheNext) {
    place_.put("a", "new");
    place_.put(".mscomp1-0/old/a", "old");
    place_.put(".mscomp1-0/new/b", "new");
    place_.put(".mscomp1-0/files", std::string("..\0a\0b\0", 7));
    recover_folder(place_.path());
    EXPECT_THAT(contents(place_.path()), ElementsAre("a old"));
}

// Where there was no earlier file, the one that was moved must not ask for --force.
TEST_F(OutputFilesTest, HalfMovedByAKilledProcessDoNotStandInTheWay) {
    place_.put("a", "new");
    place_.put("c", "mine");
    place_.put(".mscomp1-0/new/b", "new");
    fs::create_directory(place_ / ".mscomp1-0/old");
    place_.put(".mscomp1-0/files", std::string("..\0a\0b\0", 7));
    EXPECT_NO_THROW(require_free_file(place_ / "a", false));
    EXPECT_THAT(contents(place_.path()), ElementsAre("c mine"));
    EXPECT_THROW(require_free_file(place_ / "c", false), UsageError);
}

// The same of a folder that stayed itself, its files made ready beside it.
TEST_F(OutputFolders, HalfMovedByAKilledProcessAreUndoneByTheNext) {
    place_.put("out/a", "new");
    place_.put("out/mine", "old");
    place_.put(".out.mscomp1-0/old/gone", "old");
    place_.put(".out.mscomp1-0/new/b", "new");
    place_.put(".out.mscomp1-0/files", std::string("../out\0a\0b\0", 11));
    { const OutputFolder next(folder_); }
    EXPECT_THAT(contents(folder_), ElementsAre("gone old", "mine old"));
    EXPECT_THAT(place_.names(), ElementsAre("out"));
}

// Whoever may write beside us must not have us rename files elsewhere.
TEST_F(OutputFilesTest, AreNotUndoneByAListThatLeavesTheFolder) {
    place_.put("elsewhere/a", "mine");
    for (const std::string& list :
         {std::string("..\0../elsewhere/a\0", 18), std::string("../x/elsewhere\0a\0", 17)}) {
        place_.put("here/.mscomp1-0/files", list);
        place_.put("here/.mscomp1-0/new/b", "new");
        recover_folder(place_ / "here");
        EXPECT_EQ(TemporaryFolder::content(place_ / "elsewhere/a"), "mine");
    }
}

TEST(Temporaries, OfDeadProcessesAreRemovedByTheNextWriterOnly) {
    const TemporaryFolder folder;
    do_and_die([&] {
        AtomicFile file(folder / "a");
        file.write(std::string(3 << 20, 'x'));
        ::raise(SIGKILL);
    });
    ASSERT_EQ(folder.names().size(), 1u);
    EXPECT_THAT(folder.names()[0], testing::StartsWith(".a.mscomp"));
    AtomicFile living(folder / "b");
    EXPECT_EQ(folder.names().size(), 1u);
    recover_folder(folder.path());
    EXPECT_EQ(folder.names().size(), 1u);
    living.write("b");
    living.commit();
    EXPECT_THAT(folder.names(), ElementsAre("b"));
}

TEST(Temporaries, LeaveHiddenFilesOfOthersAlone) {
    const TemporaryFolder folder;
    for (const char* name : {".a.mscomp12", ".a.mscomp12-x", "a.mscomp1-2", ".mscomp"}) {
        folder.put(name, "mine");
    }
    recover_folder(folder.path());
    EXPECT_EQ(folder.names().size(), 4u);
}

TEST(Temporaries, OfTheLongestNamesHaveOne) {
    const TemporaryFolder folder;
    const std::string path = folder / std::string(255, 'n');
    write_file(path, "x");
    EXPECT_EQ(TemporaryFolder::content(path), "x");
}

}  // namespace
}  // namespace mscomp
