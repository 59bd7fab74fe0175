// SPDX-License-Identifier: MIT
// `acapfeat generate` as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Outcome {
    int code = -1;
    std::string out, err;
};

class Generate : public testing::Test {
  protected:
    Outcome run(const std::string& arguments) const {
        const std::string folder = temporary_.path();
        const std::string line = "cd '" + folder + "' && " + MSCOMP_BIN_DIR +
                                 "/acapfeat generate " + arguments + " >out.txt 2>err.txt";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(folder + "/out.txt"),
                read_file(folder + "/err.txt")};
    }
    std::string path(const std::string& name) const { return temporary_.path() + "/" + name; }

    TemporaryFolder temporary_;
};

TEST_F(Generate, WritesEachSequenceWithItsTruth) {
    for (const std::string name : {"arm", "cloth", "face", "twist"}) {
        const Outcome outcome = run(name + " -o " + name + " --frames 3 --vertices 300");
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_THAT(outcome.out, HasSubstr(name + ": 3 shapes of " + name));
        EXPECT_GE(read_mesh(path(name + "/frame_0002.obj")).vertex_count(), 300);
        EXPECT_FALSE(fs::exists(path(name + "/frame_0003.obj")));
        EXPECT_TRUE(fs::exists(path(name + "/truth.json")));
        EXPECT_TRUE(fs::exists(path(name + "/truth_supports.safetensors")));
        EXPECT_EQ(fs::exists(path(name + "/truth_rotation.safetensors")), name == "twist");
    }
}

// The bytes depend on the seed, not on the number of threads.
TEST_F(Generate, WritesTheSameBytesForAnyNumberOfThreads) {
    for (const std::string name : {"cloth", "twist --noise 0.01"}) {
        const std::string rest = " --force --frames 4 --vertices 300 -o ";
        ASSERT_EQ(run(name + rest + "a --threads 1").code, 0);
        ASSERT_EQ(run(name + rest + "b --threads 3").code, 0);
        ASSERT_EQ(run(name + rest + "c --seed 1").code, 0);
        for (const std::string file :
             {"frame_0003.obj", "truth.json", "truth_supports.safetensors"}) {
            EXPECT_EQ(read_file(path("a/" + file)), read_file(path("b/" + file)));
        }
        EXPECT_NE(read_file(path("a/frame_0003.obj")), read_file(path("c/frame_0003.obj")));
    }
}

TEST_F(Generate, TakesTheOptionsOfATwist) {
    ASSERT_EQ(
        run("twist -o bar --frames 2 --turns -2 --tilt 15 --noise 0.001 --thickness 0.1").code, 0);
    const SafetensorsFile truth(path("bar/truth_rotation.safetensors"));
    const auto rotation = truth.data<float>("rotation", {2, -1, 3});
    const float* last = rotation.data() + rotation.size() - 3;
    EXPECT_NEAR(std::hypot(last[0], last[1], last[2]), 2 * 2 * 3.14159265, 1e-4);
    EXPECT_FALSE(truth.contains("features"));
}

TEST_F(Generate, RefusesOptionsOfAnotherGenerator) {
    for (const std::string option : {"--turns", "--tilt", "--noise", "--thickness"}) {
        const Outcome outcome = run("arm -o arm " + option + " 1");
        EXPECT_EQ(outcome.code, 2);
        EXPECT_THAT(outcome.err, HasSubstr(option + " is an option of 'generate twist', got "
                                                    "'generate arm'"));
        EXPECT_FALSE(fs::exists(path("arm")));
    }
}

TEST_F(Generate, NamesItsGenerators) {
    const Outcome outcome = run("leg -o leg");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("arm,cloth,face,twist"));
    const std::string help = run("--help").out;
    for (const std::string name : {"arm", "cloth", "face", "twist"}) {
        EXPECT_THAT(help, HasSubstr(name + ": "));
        EXPECT_THAT(help, HasSubstr(name + " 60"));
    }
}

TEST_F(Generate, RefusesImpossibleSizes) {
    for (const std::string arguments :
         {"cloth --frames 1", "face --vertices 99", "twist --turns 30", "twist --noise -1",
          "arm --seed -1", "arm --frames 2000000000"}) {
        const Outcome outcome = run(arguments + " -o nothing");
        EXPECT_EQ(outcome.code, 2) << arguments;
        EXPECT_THAT(outcome.err, HasSubstr("wanted")) << arguments;
        EXPECT_FALSE(fs::exists(path("nothing")));
    }
}

}  // namespace
}  // namespace mscomp
