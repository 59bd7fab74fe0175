// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/natural_order.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(NaturalOrder, ComparesRunsOfDigitsAsNumbers) {
    EXPECT_TRUE(natural_less("frame_2", "frame_10"));
    EXPECT_FALSE(natural_less("frame_10", "frame_2"));
    EXPECT_TRUE(natural_less("frame_0002", "frame_10"));
    EXPECT_TRUE(natural_less("a2b10", "a2b11"));
    EXPECT_TRUE(natural_less("a9", "b1"));
    EXPECT_TRUE(natural_less("frame", "frame1"));
    EXPECT_TRUE(natural_less("x99999999999999999999998", "x99999999999999999999999"));
}

// Irreflexive, asymmetric, transitive, and different names are never equal: one order for all.
TEST(NaturalOrder, IsAStrictTotalOrder) {
    const std::vector<std::string> names{"",   "0",   "00", "1",    "01",  "001",
                                         "10", "a",   "a1", "a01",  "a1b", "a01b",
                                         "a2", "a10", "1a", "\xff", "a-1", "A1"};
    for (const std::string& a : names) {
        for (const std::string& b : names) {
            EXPECT_EQ(natural_less(a, b) + natural_less(b, a), a == b ? 0 : 1) << a << " " << b;
            for (const std::string& c : names) {
                EXPECT_TRUE(!natural_less(a, b) || !natural_less(b, c) || natural_less(a, c));
            }
        }
    }
}

class ExpandInputs : public testing::Test {
  protected:
    void SetUp() override {
        for (const char* name : {"f/frame_10.obj", "f/frame_2.obj", "f/frame_1.ply", "f/notes.txt",
                                 "f/frame_3.OBJ", "f/frame_4.off", "g/x[1].obj"}) {
            folder_.put(name, "");
        }
        std::filesystem::create_directories(folder_ / "f/folder.obj");
        std::filesystem::create_directories(folder_ / "none");
    }
    /// Paths relative to the folder.
    std::vector<std::string> expanded(const std::vector<std::string>& inputs) {
        std::vector<std::string> absolute;
        for (const std::string& input : inputs) absolute.push_back(folder_ / input);
        std::vector<std::string> files = expand_inputs(absolute);
        for (std::string& file : files) file = file.substr(folder_.path().size() + 1);
        return files;
    }
    std::string message_of(const std::vector<std::string>& inputs) {
        return thrown_message<UsageError>([&] { expanded(inputs); });
    }
    TemporaryFolder folder_;
};

TEST_F(ExpandInputs, TakesTheMeshesOfAFolderInNaturalOrder) {
    EXPECT_THAT(expanded({"f"}), ElementsAre("f/frame_1.ply", "f/frame_2.obj", "f/frame_3.OBJ",
                                             "f/frame_4.off", "f/frame_10.obj"));
}

// A pipe would be waited at, a link to nowhere is a shape that is missing.
TEST_F(ExpandInputs, TakesNoPipesOfAFolderButBrokenLinks) {
    const TemporaryFolder folder;
    const std::string mesh = folder.put("a.obj", ""), link = folder / "c.obj";
    ASSERT_EQ(::mkfifo((folder / "b.obj").c_str(), 0600), 0);
    std::filesystem::create_symlink("nowhere", link);
    EXPECT_THAT(expand_inputs({folder.path()}), ElementsAre(mesh, link));
}

// Side files of a Mac's archive, settings of file managers.
TEST_F(ExpandInputs, PassesOverHiddenFilesUnlessTheyAreNamed) {
    const TemporaryFolder folder;
    const std::string mesh = folder.put("0.obj", ""), hidden = folder.put("._0.obj", "");
    folder.put(".DS_Store", "");
    folder.put(".hidden.ply", "");
    folder.put("Thumbs.db", "");
    EXPECT_THAT(expand_inputs({folder.path()}), ElementsAre(mesh));
    EXPECT_THAT(expand_inputs({folder / "*.obj"}), ElementsAre(mesh));
    EXPECT_THAT(expand_inputs({hidden}), ElementsAre(hidden));
}

TEST_F(ExpandInputs, TakesPatterns) {
    EXPECT_THAT(expanded({"f/frame_*.obj"}), ElementsAre("f/frame_2.obj", "f/frame_10.obj"));
    EXPECT_THAT(expanded({"f/frame_?.*"}),
                ElementsAre("f/frame_1.ply", "f/frame_2.obj", "f/frame_3.OBJ", "f/frame_4.off"));
    EXPECT_THAT(expanded({"f/frame_[12].*"}), ElementsAre("f/frame_1.ply", "f/frame_2.obj"));
}

TEST_F(ExpandInputs, PutsFilesNamedByTheShellInNaturalOrder) {
    EXPECT_THAT(expanded({"f/frame_10.obj", "f/frame_2.obj"}),
                ElementsAre("f/frame_2.obj", "f/frame_10.obj"));
}

TEST_F(ExpandInputs, TakesAFileWhoseNameLooksLikeAPattern) {
    EXPECT_THAT(expanded({"g/x[1].obj"}), ElementsAre("g/x[1].obj"));
}

TEST_F(ExpandInputs, RefusesWhatMatchesNothing) {
    EXPECT_THAT(message_of({"f/nowhere.obj"}), HasSubstr("f/nowhere.obj"));
    EXPECT_THAT(message_of({"f/z*.obj"}), HasSubstr("f/z*.obj"));
    EXPECT_THAT(message_of({"none"}), AllOf(HasSubstr("none"), HasSubstr(".obj, .ply or .off")));
    EXPECT_THAT(thrown_message<UsageError>([] { expand_inputs({}); }), HasSubstr("no input"));
}

TEST_F(ExpandInputs, RefusesAFileNamedTwice) {
    EXPECT_THAT(message_of({"f/frame_2.obj", "f/../f/frame_2.obj"}),
                AllOf(HasSubstr("f/../f/frame_2.obj"), HasSubstr("same file")));
    EXPECT_THAT(message_of({"f", "f/*.ply"}), HasSubstr("frame_1.ply"));
}

}  // namespace
}  // namespace mscomp
