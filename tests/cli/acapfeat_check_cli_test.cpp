// SPDX-License-Identifier: MIT
// acapfeat check, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "base/temporary_folder.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

const std::string kFaces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
const std::string kRest = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + kFaces;
const std::string kTall = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1.2\n" + kFaces;
const std::string kWide = "v 0 0 0\nv 1.1 0 0\nv 0 1 0\nv 0 0 1\n" + kFaces;

struct Outcome {
    int code = -1;
    std::string out, err;
};

class CheckCommandLine : public testing::Test {
  protected:
    CheckCommandLine() {
        folder_.put("in/f_1.obj", kRest);
        folder_.put("in/f_2.obj", kTall);
        folder_.put("in/f_3.obj", kWide);
    }
    Outcome check(const std::string& arguments) const {
        const std::string line = "cd '" + folder_.path() + "' && " + std::string(MSCOMP_BIN_DIR) +
                                 "/acapfeat check " + arguments + " >out 2>err";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), TemporaryFolder::content(folder_ / "out"),
                TemporaryFolder::content(folder_ / "err")};
    }
    TemporaryFolder folder_;
};

TEST_F(CheckCommandLine, SaysInOneLineThatNothingIsWrong) {
    const Outcome outcome = check("in");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.out, HasSubstr("Nothing is wrong or odd with these meshes.\n"));
    EXPECT_THAT(outcome.out, HasSubstr("shapes        3\n"));
    EXPECT_THAT(outcome.err, HasSubstr("check"));
    EXPECT_THAT(outcome.err, Not(HasSubstr("error")));
}

TEST_F(CheckCommandLine, ErrorsAreExitCodeThreeAndAllAreShown) {
    folder_.put("in/f_4.obj", "v 0 0 0\nv 1 x 0\n");
    folder_.put("in/f_5.obj", kRest + "v 5 5 5\n");
    const Outcome outcome = check("in --quiet");
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.out, HasSubstr("in/f_4.obj:2"));
    EXPECT_THAT(outcome.out, HasSubstr("in/f_5.obj: 5 vertices"));
    EXPECT_THAT(outcome.out, HasSubstr("3 of them can be used"));
    EXPECT_THAT(outcome.err, HasSubstr("acapfeat: error: "));
}

TEST_F(CheckCommandLine, WarningsAndNotesAreExitCodeZero) {
    folder_.put("in/f_5.obj", kTall);
    const Outcome outcome = check("in --quiet");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    EXPECT_THAT(outcome.out, HasSubstr("warning: 1 shape repeats an earlier one exactly"));
    EXPECT_THAT(outcome.out, HasSubstr("note: 1 number is missing"));
}

TEST_F(CheckCommandLine, JsonHoldsEverything) {
    folder_.put("in/f_4.obj", "v 0 0 0\nv 1 x 0\n");
    folder_.put("in/f_6.obj", kTall);
    const Outcome outcome = check("in --json");
    EXPECT_EQ(outcome.code, 3);
    const Json json = Json::parse(outcome.out);
    EXPECT_EQ(json.at("files"), 5);
    EXPECT_EQ(json.at("usable"), 4);
    EXPECT_EQ(json.at("errors"), 1);
    EXPECT_EQ(json.at("warnings"), 1);
    EXPECT_EQ(json.at("notes"), 1);
    EXPECT_EQ(json.at("reference"), "in/f_1.obj");
    EXPECT_EQ(json.at("vertices"), 4);
    EXPECT_EQ(json.at("faces"), 4);
    EXPECT_EQ(json.at("edges"), 6);
    EXPECT_EQ(json.at("components"), 1);
    EXPECT_EQ(json.at("boundary_loops"), 0);
    EXPECT_EQ(json.at("bounding_box").at("highest"), Json({1.0, 1.0, 1.0}));
    EXPECT_GT(json.at("unit_ball_scale"), 1.0);
    EXPECT_GT(json.at("stretch").at("largest"), 0.0);
    ASSERT_EQ(json.at("findings").size(), 3u);
    const Json malformed = json.at("findings").at(0);
    EXPECT_EQ(malformed.at("kind"), "malformed_file");
    EXPECT_EQ(malformed.at("severity"), "error");
    EXPECT_EQ(malformed.at("count"), 1);
    EXPECT_EQ(malformed.at("places").at(0).at("file"), "in/f_4.obj");
    EXPECT_EQ(malformed.at("places").at(0).at("line"), 2);
    EXPECT_EQ(json.at("findings").at(1).at("places").at(0).at("other_file"), "in/f_2.obj");
}

TEST_F(CheckCommandLine, TenPlacesInTextAllInJson) {
    for (int k = 10; k < 30; ++k) folder_.put("in/f_" + std::to_string(k) + ".obj", kTall);
    const std::string text = check("in").out;
    EXPECT_THAT(text, HasSubstr("f_19.obj = f_2.obj"));
    EXPECT_THAT(text, Not(HasSubstr("f_20.obj = f_2.obj")));
    EXPECT_EQ(Json::parse(check("in --json").out).at("findings").at(0).at("places").size(), 20u);
}

TEST_F(CheckCommandLine, ReferenceIsAnIndexOrAFile) {
    folder_.put("rest.obj", kRest);
    EXPECT_EQ(Json::parse(check("in --json --reference 2").out).at("reference"), "in/f_3.obj");
    const Json json = Json::parse(check("in --json --reference rest.obj").out);
    EXPECT_EQ(json.at("reference"), "rest.obj");
    EXPECT_EQ(json.at("files"), 3);
    EXPECT_EQ(check("in --reference 3").code, 2);
    const Outcome missing = check("in --reference nothing.obj");
    EXPECT_EQ(missing.code, 3);
    EXPECT_THAT(missing.out, HasSubstr("the reference cannot be read"));
}

TEST_F(CheckCommandLine, ListKeepsItsOrder) {
    folder_.put("list.txt", "in/f_3.obj\nin/f_1.obj\n");
    const Json json = Json::parse(check("--list list.txt --json").out);
    EXPECT_EQ(json.at("files"), 2);
    EXPECT_EQ(json.at("reference"), "in/f_3.obj");
}

TEST_F(CheckCommandLine, WrongCommandLinesAreTwo) {
    EXPECT_EQ(check("").code, 2);
    EXPECT_EQ(check("nothing.obj").code, 2);
    EXPECT_EQ(check("in --list list.txt").code, 2);
    EXPECT_EQ(check("in --threads -1").code, 2);
}

TEST_F(CheckCommandLine, HelpEndsWithAnExample) {
    const Outcome outcome = check("--help");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.out, HasSubstr("\nExample:\n  acapfeat check"));
}

TEST_F(CheckCommandLine, ThreadsDoNotChangeAByte) {
    folder_.put("in/f_6.obj", kTall);
    const std::string one = check("in --json --threads 1").out;
    EXPECT_EQ(check("in --json --threads 2").out, one);
    EXPECT_EQ(check("in --json --threads 7").out, one);
}

}  // namespace
}  // namespace mscomp
