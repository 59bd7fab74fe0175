// SPDX-License-Identifier: MIT
// Meshes and arrays as they are found, through the commands that read them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"

namespace mscomp {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const std::string kPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

struct Outcome {
    int code = -1;
    std::string out, err;
};

class OddInputs : public testing::Test {
  protected:
    /// Runs acapfeat in the folder.
    Outcome run(const std::string& arguments) const {
        const std::string line = "cd '" + folder_.path() + "' && " + MSCOMP_BIN_DIR + "/acapfeat " +
                                 arguments + " >out 2>err";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), TemporaryFolder::content(folder_ / "out"),
                TemporaryFolder::content(folder_ / "err")};
    }
    nlohmann::json json(const std::string& arguments) const {
        return nlohmann::json::parse(run(arguments + " --json").out);
    }
    FeatureSet extracted(const std::string& inputs) const {
        const Outcome outcome = run("extract " + inputs + " -o f.safetensors --force");
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return read_features(folder_ / "f.safetensors");
    }
    void put_tetrahedron(const std::string& name, double height = 1,
                         const std::string& more = "") const {
        folder_.put(name, kPoints + "v 0.2 0.2 " + std::to_string(height) +
                              "\nf 1 3 2\nf 1 2 5\nf 2 3 5\nf 3 1 5\nf 1 2 4\n" + more);
    }

    TemporaryFolder folder_;
};

TEST_F(OddInputs, WhatIsPassedOverIsWarnedAboutByExtractAndCheck) {
    put_tetrahedron("in/1.obj", 1, "f 1 4\nzz 7\n");
    put_tetrahedron("in/2.obj", 1.2, "f 1 4\nzz 7\n");
    const Outcome outcome = run("extract in -o f.safetensors");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_THAT(outcome.err,
                AllOf(HasSubstr("warning: 2 faces of fewer than three corners in 2 of 2 files "
                                "passed over, the first in in/1.obj, line 11"),
                      HasSubstr("2 unknown statements in 2 of 2 files passed over, the first in "
                                "in/1.obj, line 12: 'zz'")));
    EXPECT_THAT(run("check in").out, AllOf(HasSubstr("[passed_over]"), HasSubstr("line 12: 'zz'")));
    EXPECT_THAT(run("info f.safetensors").out, HasSubstr("fewer than three corners"));
}

TEST_F(OddInputs, ADoubtfulOrderIsSaidUnlessAListGivesIt) {
    for (const char* name : {"in/p3.7.obj", "in/p3.12.obj"}) put_tetrahedron(name);
    EXPECT_THAT(run("extract in -o f.safetensors").err,
                HasSubstr("order of the shapes is in doubt"));
    EXPECT_THAT(run("check in").out, HasSubstr("[order_in_doubt]"));
    folder_.put("list", "in/p3.12.obj\nin/p3.7.obj\n");
    EXPECT_THAT(run("extract --list list -o g.safetensors").err, Not(HasSubstr("in doubt")));
}

TEST_F(OddInputs, FoldersTellShapesOfOneNameApart) {
    for (const char* name : {"in/take1/frame.obj", "in/take2/frame.obj"}) put_tetrahedron(name);
    put_tetrahedron("ref/frame.obj");
    EXPECT_THAT(extracted("'in/*/frame.obj'").names, ElementsAre("take1_frame", "take2_frame"));
    EXPECT_THAT(extracted("'in/*/frame.obj' --reference ref/frame.obj").names,
                ElementsAre("take1_frame", "take2_frame"));
    EXPECT_THAT(extracted("in/take1 --reference ref/frame.obj").names, ElementsAre("frame"));
}

TEST_F(OddInputs, BlanksQuotesAndLineEndsOfAListAreNoPartOfNames) {
    for (const char* name : {"in/a b.obj", "in/c.obj", "in/d.obj"}) put_tetrahedron(name);
    folder_.put("list", "# frames\r\nin/c.obj \t\r\n\r\n  \"in/a b.obj\"\r\n  # more\rin/d.obj");
    EXPECT_THAT(extracted("--list list").names, ElementsAre("c", "a b", "d"));
    folder_.put("packed", std::string("\x1f\x8b\x08\0", 4));
    const Outcome outcome = run("extract --list packed -o g.safetensors");
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr("packed: this is a gzip file: unpack it"));
}

TEST_F(OddInputs, ConvertNamesWhatIsLost) {
    folder_.put(
        "lossy.obj",
        "vt 0 0\nvn 0 0 1\nusemtl red\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0 1 0 "
        "0\nf 1/1/1 2/1/1 3/1/1 4/1/1\n");
    EXPECT_THAT(run("convert lossy.obj out.obj").err,
                AllOf(HasSubstr("note: out.obj does not hold "), HasSubstr("polygons"),
                      HasSubstr("texture coordinates"), HasSubstr("normals"),
                      HasSubstr("colours of vertices"), HasSubstr("materials")));
    EXPECT_THAT(json("convert lossy.obj out.ply")["lost"].dump(), HasSubstr("polygons"));
    put_tetrahedron("plain.obj");
    EXPECT_THAT(run("convert plain.obj plain.off").err, Not(HasSubstr("note")));
}

// The features of a set of quads, wherever their faces begin.
TEST_F(OddInputs, FeaturesDoNotDependOnTheFirstCornersOfPolygons) {
    const auto put_grid = [&](const std::string& name, int start, double height) {
        std::string text;
        for (int i = 0; i < 9; ++i) {
            const double z = i == 4 ? height : 0.1 * (i % 2);
            text += "v " + std::to_string(i % 3) + " " + std::to_string(i / 3) + " " +
                    std::to_string(z) + "\n";
        }
        for (const int corner : {1, 2, 4, 5}) {
            const int ring[] = {corner, corner + 1, corner + 4, corner + 3};
            text += "f";
            for (int k = 0; k < 4; ++k) text += " " + std::to_string(ring[(k + start) % 4]);
            text += "\n";
        }
        folder_.put(name, text);
    };
    std::vector<float> wanted;
    for (int start = 0; start < 4; ++start) {
        put_grid("in/1.obj", start, 0);
        put_grid("in/2.obj", start, 0.5);
        const FeatureSet set = extracted("in");
        if (start == 0) wanted = set.features;
        EXPECT_EQ(set.features, wanted);
    }
}

TEST_F(OddInputs, FilesOfOtherKindsAreNamedByEveryCommandThatReadsMeshes) {
    folder_.put("a.obj", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1\n");
    for (const char* command :
         {"extract a.obj -o f", "convert a.obj b.ply", "convert a.obj b.npz"}) {
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.code, 3) << command;
        EXPECT_THAT(outcome.err, HasSubstr("a.obj: this is a Git LFS pointer: run git lfs pull"));
    }
    EXPECT_THAT(run("check a.obj").out, HasSubstr("Git LFS pointer"));
}

}  // namespace
}  // namespace mscomp
