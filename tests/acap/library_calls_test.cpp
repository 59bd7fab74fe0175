// SPDX-License-Identifier: MIT
// Which functions of OpenMesh and Ceres the programs call by themselves, seen by a debugger.
// Skipped where there is no gdb, or it may not look at other processes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kLeastSquares = "ceres::Solve(ceres::Solver::Options const&";
constexpr const char* kDescent = "ceres::Solve(ceres::GradientProblemSolver::Options const&";

/// An arm, a bar of two and a half turns, and components of the arm; shared by all tests.
class LibraryCalls : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new TemporaryFolder;
        has_gdb_ = shell(
                       "gdb -q -nx -batch -ex run -ex quit --args /bin/true >gdb.txt 2>&1 && "
                       "grep -q 'exited normally' gdb.txt") == 0;
        if (!has_gdb_) return;
        write_file(
            path("config.yaml"),
            "model: {kind: stacked-attention, levels: [{components: 4, sparsity_range: 0.3}]}\n"
            "data: {features: arm.safetensors, split: {train: every, step: 3}}\n"
            "train: {epochs: 20, batch: 4}\n");
        ASSERT_EQ(shell(acapfeat("generate arm -o arm --frames 8 --vertices 400 --quiet")), 0);
        ASSERT_EQ(shell(acapfeat("generate twist -o bar --frames 6 --vertices 400 --quiet")), 0);
        ASSERT_EQ(shell(acapfeat("extract arm -o arm.safetensors --quiet")), 0);
        ASSERT_EQ(shell(mscomp("train config.yaml -o run --quiet")), 0);
    }
    static void TearDownTestSuite() {
        delete folder_;
        folder_ = nullptr;
    }
    void SetUp() override {
        if (!has_gdb_) GTEST_SKIP() << "gdb is absent or may not look at other processes";
    }

    static std::string path(const std::string& name) { return *folder_ / name; }
    static int shell(const std::string& command) {
        return std::system(("cd '" + path("") + "' && " + command).c_str());
    }
    static std::string acapfeat(const std::string& arguments) {
        return std::string(MSCOMP_BIN_DIR) + "/acapfeat " + arguments;
    }
    static std::string mscomp(const std::string& arguments) {
        return std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments;
    }
    /// The callers, innermost first, where `program` comes to `function` for the first time;
    /// without any if it ends before.
    static std::string first_call(const std::string& function, const std::string& program) {
        shell("gdb -q -nx -batch -ex 'set breakpoint pending on' -ex 'break " + function +
              "' -ex run -ex 'backtrace 12' -ex kill --args " + program + " >calls.txt 2>&1");
        return read_file(path("calls.txt"));
    }

    static TemporaryFolder* folder_;
    static bool has_gdb_;
};
TemporaryFolder* LibraryCalls::folder_ = nullptr;
bool LibraryCalls::has_gdb_ = false;

// The mesh whose one-rings the features are computed on is an OpenMesh mesh.
TEST_F(LibraryCalls, ExtractionBuildsItsMeshWithOpenMesh) {
    const std::string callers = first_call("OpenMesh::PolyConnectivity::add_face",
                                           acapfeat("extract arm -o again.safetensors --force"));
    EXPECT_THAT(callers, HasSubstr("mscomp::SurfaceMesh::SurfaceMesh"));
    EXPECT_THAT(callers, HasSubstr("mscomp::DeformationGradients::DeformationGradients"));
}

// Several turns: the bound of the single edges does not prove them, so they are relaxed.
TEST_F(LibraryCalls, ExtractionRelaxesTurnsWithCeres) {
    const std::string callers =
        first_call("ceres::Solve", acapfeat("extract bar -o bar.safetensors --force"));
    EXPECT_THAT(callers, HasSubstr(kLeastSquares));
    EXPECT_THAT(callers, HasSubstr("mscomp::relaxed_turns"));
}

TEST_F(LibraryCalls, DecodedFeaturesBecomeVerticesByCeres) {
    for (const char* command : {"reconstruct run arm.safetensors -o decoded", "evaluate run"}) {
        const std::string callers = first_call("ceres::Solve", mscomp(command));
        EXPECT_THAT(callers, HasSubstr(kDescent)) << command;
        EXPECT_THAT(callers, HasSubstr("mscomp::LosslessReconstruction::solve")) << command;
    }
}

TEST_F(LibraryCalls, CodesAreFittedToVerticesByCeres) {
    const std::string callers =
        first_call("ceres::Problem::AddResidualBlock", mscomp("evaluate run --fit vertices"));
    EXPECT_THAT(callers, HasSubstr("mscomp::VertexFit::fit"));
}

// Features of a mesh have their mesh from the linear solve: there is nothing to descend.
TEST_F(LibraryCalls, FeaturesOfAMeshNeedNoDescent) {
    const std::string callers =
        first_call("ceres::Solve", acapfeat("reconstruct arm.safetensors -o arm_again --force"));
    EXPECT_THAT(callers, Not(HasSubstr(kDescent)));
    EXPECT_THAT(callers, HasSubstr("exited normally"));
}

}  // namespace
}  // namespace mscomp
