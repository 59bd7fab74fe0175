// SPDX-License-Identifier: MIT
#include "mscomp/base/atomic_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <stdexcept>

#include "base/full_disk.h"
#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(AtomicFile, AppearsOnlyWithCommit) {
    const TemporaryFolder folder;
    {
        AtomicFile file(folder / "a.txt");
        file.write("half");
        EXPECT_FALSE(std::filesystem::exists(folder / "a.txt"));
    }
    EXPECT_THAT(folder.names(), IsEmpty());
    AtomicFile file(folder / "a.txt");
    file.write("who");
    file.write("le");
    file.commit();
    EXPECT_THAT(folder.names(), ElementsAre("a.txt"));
    EXPECT_EQ(TemporaryFolder::content(folder / "a.txt"), "whole");
}

TEST(AtomicFile, ReplacesAnEarlierFileWhole) {
    const TemporaryFolder folder;
    const std::string path = folder.put("a.txt", "a longer earlier text");
    write_file(path, "new");
    EXPECT_EQ(TemporaryFolder::content(path), "new");
}

TEST(AtomicFile, CreatesMissingFolders) {
    const TemporaryFolder folder;
    write_file(folder / "x/y/a.txt", "text");
    EXPECT_EQ(TemporaryFolder::content(folder / "x/y/a.txt"), "text");
}

TEST(AtomicFile, OnAFullDiskKeepsTheEarlierFileAndSaysWhy) {
    const TemporaryFolder folder;
    const std::string path = folder.put("a.txt", "earlier");
    const std::string large(1 << 20, 'x');
    std::string message;
    {
        const FullDisk full(1 << 16);
        message = thrown_message<IoError>([&] { write_file(path, large); });
    }
    EXPECT_THAT(message, HasSubstr(path));
    EXPECT_THAT(message, HasSubstr("File too large"));
    EXPECT_THAT(folder.names(), ElementsAre("a.txt"));
    EXPECT_EQ(TemporaryFolder::content(path), "earlier");
}

// Small files stay in the library's buffer until they are flushed: the failure comes late.
TEST(AtomicFile, NoticesAFullDiskWhenItFlushes) {
    const TemporaryFolder folder;
    const std::string path = folder.put("a.txt", "earlier");
    std::string message;
    {
        AtomicFile file(path);
        file.write("0123456789");
        const FullDisk full(4);
        message = thrown_message<IoError>([&] { file.commit(); });
    }
    EXPECT_THAT(message, HasSubstr("File too large"));
    EXPECT_THAT(folder.names(), ElementsAre("a.txt"));
    EXPECT_EQ(TemporaryFolder::content(path), "earlier");
}

TEST(AtomicFile, RefusedByTheCheckLeavesTheEarlierFile) {
    const TemporaryFolder folder;
    const std::string path = folder.put("a.txt", "earlier");
    {
        AtomicFile file(path);
        file.write("new");
        EXPECT_THROW(file.commit([](const std::string& temporary) {
            EXPECT_EQ(TemporaryFolder::content(temporary), "new");
            throw std::runtime_error("refused");
        }),
                     std::runtime_error);
    }
    EXPECT_THAT(folder.names(), ElementsAre("a.txt"));
    EXPECT_EQ(TemporaryFolder::content(path), "earlier");
}

// A disk that returns other bytes than it was given must not go unnoticed.
TEST(AtomicFile, NoticesThatOtherBytesArrived) {
    const TemporaryFolder folder;
    std::string message;
    {
        AtomicFile file(folder / "a.txt");
        file.write(std::string(1 << 16, 'x'));
        const std::vector<std::string> names = folder.names();
        ASSERT_EQ(names.size(), 1u);
        // Another writer spoils what is to be written: the file gets longer than intended.
        std::filesystem::resize_file(folder / names[0], 1 << 17);
        message = thrown_message<IoError>([&] { file.commit(); });
    }
    EXPECT_THAT(message, HasSubstr("differs"));
    EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(AtomicFile, WillNotReplaceWhatIsNotAFile) {
    const TemporaryFolder folder;
    EXPECT_THAT(thrown_message<IoError>([&] { write_file(folder.path(), ""); }),
                HasSubstr("folder"));
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_THAT(thrown_message<IoError>([&] { write_file(folder / "pipe", ""); }),
                HasSubstr("regular"));
    EXPECT_THAT(folder.names(), ElementsAre("pipe"));
}

TEST(AtomicFile, NamesTheReasonWhenAFolderCannotBeMade) {
    const TemporaryFolder folder;
    const std::string file = folder.put("file", "");
    EXPECT_THAT(thrown_message<IoError>([&] { write_file(file + "/x/a.txt", ""); }),
                HasSubstr("Not a directory"));
}

TEST(ReadFile, ReturnsEveryByte) {
    const TemporaryFolder folder;
    std::string bytes;
    for (int i = 0; i < 3 << 20; ++i) bytes += static_cast<char>(i * 31 >> 3);
    EXPECT_TRUE(read_file(folder.put("b", bytes)) == bytes);
    EXPECT_EQ(read_file(folder.put("empty", "")), "");
}

TEST(ReadFile, NamesTheFileAndTheReason) {
    const TemporaryFolder folder;
    EXPECT_THAT(thrown_message<IoError>([&] { read_file(folder / "nowhere"); }),
                testing::AllOf(HasSubstr("nowhere"), HasSubstr("No such file")));
    EXPECT_THAT(thrown_message<IoError>([&] { read_file(folder.path()); }), HasSubstr("folder"));
}

}  // namespace
}  // namespace mscomp
