// SPDX-License-Identifier: MIT
// What is in an output folder, and when, while new files take their places.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/output_folder.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

/// What happened to the names in a folder since it was made, wherever the folder went.
class NameEvents {
  public:
    explicit NameEvents(const std::string& folder) : descriptor_(::inotify_init1(IN_NONBLOCK)) {
        EXPECT_GE(::inotify_add_watch(descriptor_, folder.c_str(), IN_CREATE | IN_MOVE | IN_DELETE),
                  0);
    }
    NameEvents(const NameEvents&) = delete;
    NameEvents& operator=(const NameEvents&) = delete;
    ~NameEvents() { ::close(descriptor_); }

    /// "name made", "name came", "name went", "name removed", in order, of one name.
    std::vector<std::string> of(const std::string& name) const {
        std::vector<std::string> all;
        alignas(inotify_event) std::array<char, 1 << 14> bytes{};
        ssize_t size = 0;
        while ((size = ::read(descriptor_, bytes.data(), bytes.size())) > 0) {
            for (const char* at = bytes.data(); at < bytes.data() + size;) {
                const auto* event = reinterpret_cast<const inotify_event*>(at);
                if (event->len > 0 && event->name == name) all.push_back(word_of(event->mask));
                at += sizeof(inotify_event) + event->len;
            }
        }
        return all;
    }

  private:
    static std::string word_of(std::uint32_t mask) {
        if ((mask & IN_CREATE) != 0) return "made";
        if ((mask & IN_MOVED_TO) != 0) return "came";
        return (mask & IN_MOVED_FROM) != 0 ? "went" : "removed";
    }

    int descriptor_;
};

class FolderExchange : public testing::Test {
  protected:
    std::string content(const std::string& name) const {
        return fs::exists(folder_ + "/" + name) ? TemporaryFolder::content(folder_ + "/" + name)
                                                : "nothing";
    }

    TemporaryFolder place_;
    std::string folder_ = place_ / "out";
};

// A process that is killed right after the exchange must not leave them in what the next one
// removes: they are in the new folder before it has its place, by a second name.
TEST_F(FolderExchange, FilesOfOthersAreNeverMissing) {
    place_.put("out/a", "old");
    place_.put("out/mine", "mine");
    OutputFolder output(folder_);
    write_file(output.path("a"), "new");
    const NameEvents events(fs::path(output.path("a")).parent_path().string());
    output.commit();
    EXPECT_THAT(events.of("mine"), testing::ElementsAre("made"));
    EXPECT_EQ(content("mine"), "mine");
}

// While the output still lives: what fails is undone before the error is seen.
TEST_F(FolderExchange, WhatFailsInTheMiddleIsUndoneAtOnce) {
    for (const char* name : {"a", "b", "c", "dropped"}) {
        place_.put(std::string("out/") + name, "old");
    }
    fs::create_directory(folder_ + "/holds it in place");
    for (const char* failing : {"a", "b", "c"}) {
        OutputFolder output(folder_);
        output.drop("dropped");
        for (const char* name : {"a", "b", "c", "fresh"}) {
            if (std::string(name) != failing) write_file(output.path(name), "new");
        }
        // No folder can take the place of a file.
        fs::create_directory(output.path(failing));
        EXPECT_THROW(output.commit(), IoError);
        for (const char* name : {"a", "b", "c", "dropped"}) {
            EXPECT_EQ(content(name), "old") << name << ", " << failing << " failed";
        }
        EXPECT_EQ(content("fresh"), "nothing") << failing << " failed";
    }
}

}  // namespace
}  // namespace mscomp
