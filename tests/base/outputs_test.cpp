// SPDX-License-Identifier: MIT
#include "mscomp/base/outputs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

class Outputs : public testing::Test {
  protected:
    Outputs() {
        std::filesystem::create_directories(folder_ + "/empty");
        write_file(folder_ + "/full/file", "x");
    }

    TemporaryFolder temporary_;
    std::string folder_ = temporary_.path();
};

std::string refusal(const std::function<void()>& call) {
    try {
        call();
    } catch (const UsageError& error) {
        return error.what();
    }
    return "accepted";
}

TEST_F(Outputs, AFileIsReplacedOnlyByForce) {
    const std::string file = folder_ + "/full/file";
    EXPECT_THAT(refusal([&] { require_free_file(file, false); }), testing::HasSubstr("--force"));
    EXPECT_NO_THROW(require_free_file(file, true));
    EXPECT_NO_THROW(require_free_file(folder_ + "/new", false));
    EXPECT_THROW(require_free_file(folder_ + "/empty", true), UsageError);
}

TEST_F(Outputs, ADanglingLinkIsInTheWayToo) {
    std::filesystem::create_symlink("nowhere", folder_ + "/link");
    EXPECT_THROW(require_free_file(folder_ + "/link", false), UsageError);
}

TEST_F(Outputs, AFolderWithSomethingInItIsUsedOnlyByForce) {
    EXPECT_THAT(refusal([&] { require_free_folder(folder_ + "/full", false); }),
                testing::HasSubstr("--force"));
    EXPECT_NO_THROW(require_free_folder(folder_ + "/full", true));
    EXPECT_NO_THROW(require_free_folder(folder_ + "/empty", false));
    EXPECT_NO_THROW(require_free_folder(folder_ + "/new", false));
    EXPECT_THROW(require_free_folder(folder_ + "/full/file", true), UsageError);
}

TEST_F(Outputs, AFolderThatCannotBeMadeIsAnIoError) {
    create_folder(folder_ + "/a/b/c");
    EXPECT_TRUE(std::filesystem::is_directory(folder_ + "/a/b/c"));
    EXPECT_THROW(create_folder(folder_ + "/full/file/below"), IoError);
}

}  // namespace
}  // namespace mscomp
