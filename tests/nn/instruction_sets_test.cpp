// SPDX-License-Identifier: MIT
// What holds for the kernels that this processor gets holds for all that it has: the tests of
// models, run again with each instruction set.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "nn/kernels/kernels.h"

namespace mscomp::nn {
namespace {

class EachInstructionSet : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        if (find_kernels<float>(GetParam()) == nullptr) GTEST_SKIP() << "not on this processor";
    }

    void passes(const std::string& program, const std::string& filter) {
        const std::string line =
            "GOMP_SPINCOUNT=20000 MSCOMP_INSTRUCTION_SET=" + std::string(GetParam()) + " '" +
            MSCOMP_BIN_DIR + "/" + program + "' --gtest_filter='" + filter + "' >'" +
            folder_.path() + "/out' 2>&1";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << program << "\n"
                                                                   << read_file(folder_ / "out");
        EXPECT_EQ(read_file(folder_ / "out").find("Running 0 tests"), std::string::npos);
    }

  private:
    TemporaryFolder folder_;
};

TEST_P(EachInstructionSet, MatchesTheReferenceCases) {
    passes("nn_reference_test", "*");
    passes("nn_spectral_reference_test", "*");
}

// Fused against small ops, bits over threads, resume, supports.
TEST_P(EachInstructionSet, PassesTheTestsOfTraining) {
    passes("nn_test", "*FusedAutoencoder*:Training.*:ModelFileTest.*:Supports*:*ThreadsDoNot*");
}

INSTANTIATE_TEST_SUITE_P(All, EachInstructionSet, testing::Values("generic", "avx2", "avx512"));

}  // namespace
}  // namespace mscomp::nn
