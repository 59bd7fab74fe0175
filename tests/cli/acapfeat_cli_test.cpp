// SPDX-License-Identifier: MIT
// The built programs, run as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/config/config_file.h"
#include "shapes.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::HasSubstr;

const std::string kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
const std::string kFaces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

struct Outcome {
    int code = -1;
    std::string out, err;
};

class Programs : public testing::Test {
  protected:
    Programs() { fs::create_directories(folder_ + "/work"); }

    std::string path(const std::string& name) const { return folder_ + "/work/" + name; }

    // Runs in the work folder; quoting is the caller's.
    Outcome run(const std::string& command) const {
        const std::string line = "cd '" + folder_ + "/work' && " + std::string(MSCOMP_BIN_DIR) +
                                 "/" + command + " >'" + folder_ + "/out' 2>'" + folder_ + "/err'";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(folder_ + "/out"), read_file(folder_ + "/err")};
    }

    std::set<std::string> files() const {
        std::set<std::string> names;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ + "/work")) {
            names.insert(fs::relative(entry.path(), folder_ + "/work").string());
        }
        return names;
    }

    // A failing command leaves the folder as it was.
    Outcome run_failing(const std::string& command, int code) const {
        const std::set<std::string> before = files();
        Outcome outcome = run(command);
        EXPECT_EQ(outcome.code, code) << command << "\n" << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(": error: ")) << command;
        EXPECT_EQ(outcome.out, "") << command;
        EXPECT_EQ(files(), before) << command;
        return outcome;
    }

    TemporaryFolder temporary_;
    std::string folder_ = temporary_.path();
};

// One rotation about an oblique axis and a shift, of more than a right angle for `step` > 1.
TriangleMesh moved(TriangleMesh mesh, int step) {
    const double angle = 0.8 * step;
    const double c = std::cos(angle), s = std::sin(angle);
    for (Point& p : mesh.vertices) {
        const Point q{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
        p = {q[0] + step, 0.6 * q[1] - 0.8 * q[2] - step, 0.8 * q[1] + 0.6 * q[2] + 3};
    }
    return mesh;
}

class RigidSequence : public Programs {
  protected:
    RigidSequence() {
        for (const int frame : {0, 2, 10}) write_obj(path(frame_name(frame)), frames(frame));
    }
    static std::string frame_name(int frame) {
        return "in/frame_" + std::to_string(frame) + ".obj";
    }
    static TriangleMesh frames(int frame) {
        const TriangleMesh sphere = shapes::icosphere(2);
        return frame == 0 ? sphere : moved(sphere, frame);
    }
};

TEST_F(Programs, HelpOfEveryCommandEndsWithAnExample) {
    for (const char* command : {"acapfeat extract", "acapfeat reconstruct", "acapfeat info",
                                "acapfeat generate", "mscomp init"}) {
        const Outcome outcome = run(std::string(command) + " --help");
        EXPECT_EQ(outcome.code, 0);
        EXPECT_THAT(outcome.out, HasSubstr(std::string("\nExample:\n  ") + command));
        EXPECT_EQ(outcome.err, "");
    }
    EXPECT_EQ(run("acapfeat --help").code, 0);
    EXPECT_EQ(run("mscomp --version").code, 0);
}

TEST_F(Programs, AWrongCommandLineIsTwo) {
    write_file(path("a.obj"), kTetrahedron + kFaces);
    run_failing("acapfeat", 2);
    EXPECT_THAT(run_failing("acapfeat exract a.obj -o f.safetensors", 2).err,
                HasSubstr("there is no command 'exract'; the nearest one is 'extract'"));
    run_failing("acapfeat extract a.obj", 2);
    run_failing("acapfeat extract -o f.safetensors", 2);
    run_failing("acapfeat extract a.obj -o f.safetensors --weights heavy", 2);
    for (const std::string index : {"1", "-1"}) {
        for (const std::string command : {"extract a.obj -o f.safetensors", "check a.obj"}) {
            EXPECT_THAT(run_failing("acapfeat " + command + " --reference " + index, 2).err,
                        HasSubstr("got " + index + ", wanted 0 to 0"));
        }
    }
    run_failing("acapfeat extract nothing.obj -o f.safetensors", 2);
    run_failing("acapfeat generate leg -o leg", 2);
    EXPECT_THAT(run_failing("mscomp init pcaa", 2).err, HasSubstr("stacked-attention"));
}

TEST_F(Programs, ABadMeshIsThreeWithFileAndLine) {
    write_file(path("good.obj"), kTetrahedron + kFaces);
    const auto refusal = [&](const std::string& text) {
        write_file(path("late.obj"), text);
        return run_failing("acapfeat extract good.obj late.obj -o f.safetensors", 3).err;
    };
    EXPECT_THAT(refusal(kTetrahedron + "f 1 3 9\n"), HasSubstr("late.obj:5"));
    EXPECT_THAT(refusal("v 0 0 nan\n" + kTetrahedron + kFaces), HasSubstr("late.obj:1"));
    EXPECT_THAT(refusal("v 0,5 0 0\n" + kTetrahedron + kFaces), HasSubstr("late.obj:1"));
    EXPECT_THAT(refusal("v 0 0"), HasSubstr("late.obj:1"));
    EXPECT_THAT(refusal(kTetrahedron + "v 5 5 5\n" + kFaces), HasSubstr("late.obj"));
    EXPECT_THAT(refusal(kTetrahedron + "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n"),
                HasSubstr("late.obj"));
}

TEST_F(Programs, AMissingOrUnwritableFileIsFour) {
    run_failing("acapfeat info missing.safetensors", 4);
    run_failing("acapfeat reconstruct missing.safetensors -o out", 4);
    write_file(path("a.obj"), kTetrahedron + kFaces);
    run_failing("acapfeat extract a.obj -o /proc/none/f.safetensors", 4);
    run_failing("acapfeat extract --list missing.txt -o f.safetensors", 4);
    write_file(path("list.txt"), "a.obj\nb.obj\n");
    EXPECT_THAT(run_failing("acapfeat extract --list list.txt -o f.safetensors", 4).err,
                HasSubstr("list.txt:2"));
}

TEST_F(Programs, ADamagedFeatureFileIsThree) {
    write_file(path("a.obj"), kTetrahedron + kFaces);
    ASSERT_EQ(run("acapfeat extract a.obj -o f.safetensors").code, 0);
    const std::string whole = read_file(path("f.safetensors"));
    write_file(path("short.safetensors"), whole.substr(0, whole.size() - 5));
    std::string altered = whole;
    altered.back() = static_cast<char>(altered.back() ^ 1);
    write_file(path("altered.safetensors"), altered);
    for (const std::string name : {"short.safetensors", "altered.safetensors", "a.obj"}) {
        run_failing("acapfeat info " + name, 3);
        run_failing("acapfeat reconstruct " + name + " -o out", 3);
    }
}

TEST_F(RigidSequence, ExistingOutputStaysUnlessForced) {
    write_file(path("f.safetensors"), "precious");
    EXPECT_THAT(run_failing("acapfeat extract in -o f.safetensors", 2).err, HasSubstr("--force"));
    write_file(path("bad.obj"), "v 1\n");
    run_failing("acapfeat extract bad.obj -o f.safetensors --force", 3);
    EXPECT_EQ(read_file(path("f.safetensors")), "precious");
    EXPECT_EQ(run("acapfeat extract in -o f.safetensors --force").code, 0);
    EXPECT_NE(read_file(path("f.safetensors")), "precious");

    write_file(path("out/mine.txt"), "mine");
    EXPECT_THAT(run_failing("acapfeat reconstruct f.safetensors -o out", 2).err,
                HasSubstr("--force"));
    EXPECT_EQ(run("acapfeat reconstruct f.safetensors -o out --force").code, 0);
    EXPECT_EQ(read_file(path("out/mine.txt")), "mine");
}

// A rigid motion leaves S = I and, after alignment, r = 0.
TEST_F(RigidSequence, RigidMotionsHaveTheFeatureOfTheReference) {
    const Outcome extracted = run("acapfeat extract in -o f.safetensors --json");
    ASSERT_EQ(extracted.code, 0) << extracted.err;
    const auto summary = nlohmann::json::parse(extracted.out);
    EXPECT_EQ(summary["shapes"], 3);
    const Outcome outcome = run("acapfeat info f.safetensors --json");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto info = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(info["vertices"], shapes::icosphere(2).vertex_count());
    EXPECT_EQ(info["faces"], shapes::icosphere(2).face_count());
    EXPECT_EQ(info["names"], nlohmann::json({"frame_0", "frame_2", "frame_10"}));
    EXPECT_NEAR(info["rotation_vector"]["lowest"]["value"].get<double>(), 0, 1e-6);
    EXPECT_NEAR(info["rotation_vector"]["highest"]["value"].get<double>(), 0, 1e-6);
    EXPECT_NEAR(info["stretch"]["lowest"]["value"].get<double>(), 0, 1e-6);
    EXPECT_NEAR(info["stretch"]["highest"]["value"].get<double>(), 1, 1e-6);
    for (const double energy : info["consistency_energy"]) EXPECT_NEAR(energy, 0, 1e-9);
}

// Of constant rotation and S = I the Poisson equation has the rigidly moved mesh as its solution.
TEST_F(RigidSequence, RigidMotionsComeBackWhereTheyStood) {
    ASSERT_EQ(run("acapfeat extract in -o f.safetensors").code, 0);
    for (const std::string format : {"obj", "ply"}) {
        const Outcome outcome = run("acapfeat reconstruct f.safetensors -o " + format +
                                    " --format " + format + " --frames 1:");
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_FALSE(fs::exists(path(format + "/frame_0." + format)));
        for (const int frame : {2, 10}) {
            const TriangleMesh wanted = frames(frame);
            const TriangleMesh mesh =
                read_mesh(path(format + "/frame_" + std::to_string(frame) + "." + format));
            EXPECT_EQ(mesh.faces, wanted.faces);
            ASSERT_EQ(mesh.vertex_count(), wanted.vertex_count());
            double largest = 0;
            for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const double error = std::abs(mesh.vertices[i][k] - wanted.vertices[i][k]);
                    if (!(error <= largest)) largest = error;
                }
            }
            EXPECT_TRUE(largest <= 1e-5) << largest;
        }
    }
}

TEST_F(RigidSequence, AReferenceFileServesLikeItsIndex) {
    ASSERT_EQ(run("acapfeat extract in -o a.safetensors --reference 1 --quiet").code, 0);
    ASSERT_EQ(run("acapfeat extract in -o b.safetensors --reference in/frame_2.obj --quiet").code,
              0);
    const FeatureSet a = read_features(path("a.safetensors"));
    const FeatureSet b = read_features(path("b.safetensors"));
    EXPECT_EQ(a.features, b.features);
    EXPECT_EQ(a.names, b.names);
    EXPECT_EQ(a.reference.vertices, b.reference.vertices);
}

TEST_F(RigidSequence, AListKeepsItsOrder) {
    write_file(path("in/list.txt"),
               "\xef\xbb\xbf# of today\nframe_10.obj\r\n\n#no.obj\nframe_0.obj\n");
    ASSERT_EQ(run("acapfeat extract --list in/list.txt -o f.safetensors").code, 0);
    EXPECT_THAT(read_features(path("f.safetensors")).names,
                testing::ElementsAre("frame_10", "frame_0"));
}

TEST_F(RigidSequence, ABrokenLastShapeLeavesNothing) {
    const std::string sound = read_file(path(frame_name(10)));
    write_file(path("in/frame_11.obj"), sound.substr(0, sound.size() / 2));
    EXPECT_THAT(run_failing("acapfeat extract in -o f.safetensors", 3).err,
                HasSubstr("frame_11.obj"));
    write_file(path("in/frame_11.obj"), sound);
    EXPECT_EQ(run("acapfeat extract in -o f.safetensors").code, 0);
}

TEST_F(RigidSequence, AReferenceOfAnotherConnectivityIsThree) {
    write_obj(path("other.obj"), shapes::icosphere(1));
    EXPECT_THAT(run_failing("acapfeat extract in -o f.safetensors --reference other.obj", 3).err,
                HasSubstr("other.obj"));
}

// Room on the disk is claimed before anything is computed. The limit here makes it small.
TEST_F(RigidSequence, AFullDiskIsFourAndLeavesNothing) {
    const std::set<std::string> before = files();
    const std::string line = "cd '" + folder_ + "/work' && trap '' XFSZ && ulimit -f 4 && '" +
                             std::string(MSCOMP_BIN_DIR) +
                             "/acapfeat' extract in -o f.safetensors >/dev/null 2>'" + folder_ +
                             "/err'";
    const int status = std::system(line.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 4);
    EXPECT_THAT(read_file(folder_ + "/err"), HasSubstr("f.safetensors: cannot write"));
    EXPECT_EQ(files(), before);
}

TEST_F(RigidSequence, OneShapeIsNotCalledShapes) {
    const Outcome one = run("acapfeat extract in/frame_0.obj -o f.safetensors");
    EXPECT_THAT(one.out, HasSubstr("f.safetensors: 1 shape, 162 vertices, 320 faces"));
    EXPECT_THAT(one.out, HasSubstr("for 1 of 1 shape;"));
}

// Vertices have one number in all that is said to people, from 1 as in OBJ files, and one in all
// that programs read, from 0.
TEST_F(RigidSequence, InfoCountsVerticesAsItsWarningsDo) {
    ASSERT_EQ(run("acapfeat extract in -o f.safetensors").code, 0);
    const std::string text = run("acapfeat info f.safetensors").out;
    const auto info = nlohmann::json::parse(run("acapfeat info f.safetensors --json").out);
    for (const char* what : {"rotation_vector", "stretch"}) {
        for (const char* end : {"lowest", "highest"}) {
            EXPECT_THAT(text,
                        HasSubstr("vertex " +
                                  std::to_string(info[what][end]["vertex"].get<int>() + 1) + ")"));
        }
    }
    EXPECT_THAT(text, HasSubstr("counted from 1 (from 0 with --json)"));
}

TEST_F(RigidSequence, InfoReportsEveryEnergyOfEveryShape) {
    ASSERT_EQ(run("acapfeat extract in -o f.safetensors").code, 0);
    const auto info = nlohmann::json::parse(run("acapfeat info f.safetensors --json").out);
    for (const char* key :
         {"principal_energy", "propagation_energy", "relaxation_energy", "consistency_energy",
          "consistency_gap", "largest_jump", "large_jumps", "inherent_jumps", "removable_jumps"}) {
        EXPECT_EQ(info[key].size(), 3u) << key;
    }
    // A rigid motion has the same rotation everywhere: least without any search.
    EXPECT_EQ(info["proved"], 3);
    for (const auto& energy : info["relaxation_energy"]) EXPECT_TRUE(energy.is_null());
    EXPECT_THAT(run("acapfeat info f.safetensors").out, HasSubstr("3 of 3 shapes"));
}

TEST_F(RigidSequence, TheFileDoesNotDependOnTheThreads) {
    ASSERT_EQ(run("acapfeat extract in -o f1.safetensors --threads 1").code, 0);
    ASSERT_EQ(run("acapfeat extract in -o f7.safetensors --threads 7").code, 0);
    EXPECT_EQ(read_features(path("f1.safetensors")).features,
              read_features(path("f7.safetensors")).features);
}

TEST_F(RigidSequence, QuietLeavesStandardErrorEmpty) {
    const Outcome outcome = run("acapfeat extract in -o f.safetensors --quiet");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
}

TEST_F(RigidSequence, AnUnknownSolverOrFramesThatAreNotThereAreTwo) {
    ASSERT_EQ(run("acapfeat extract in -o f.safetensors").code, 0);
    run_failing("acapfeat reconstruct f.safetensors -o out --solver magic", 2);
    run_failing("acapfeat reconstruct f.safetensors -o out --frames 2:9", 2);
}

TEST_F(Programs, AGeneratedSequenceCanBeExtracted) {
    const Outcome generated = run("acapfeat generate arm -o arm --frames 3 --vertices 400");
    ASSERT_EQ(generated.code, 0) << generated.err;
    run_failing("acapfeat generate arm -o arm --frames 3", 2);
    const Outcome extracted = run("acapfeat extract 'arm/*.obj' -o arm.safetensors --json");
    ASSERT_EQ(extracted.code, 0) << extracted.err;
    const auto summary = nlohmann::json::parse(extracted.out);
    EXPECT_EQ(summary["shapes"], 3);
    EXPECT_GE(summary["vertices"], 400);
}

TEST_F(Programs, ResultsThatCannotBePrintedAreAnIoError) {
    EXPECT_EQ(std::system((std::string(MSCOMP_BIN_DIR) +
                           "/mscomp init stacked-attention >/dev/full 2>/dev/null")
                              .c_str()),
              4 << 8);
}

TEST_F(Programs, InitPrintsAConfigurationThatReads) {
    const Outcome outcome = run("mscomp init stacked-attention");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out, config_template("stacked-attention"));
}

}  // namespace
}  // namespace mscomp
