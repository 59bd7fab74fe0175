// SPDX-License-Identifier: MIT
// The ACAP authors' own test: a twisted bar and what their program computed for it.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "acap_cases.h"
#include "mscomp/acap/mesh/mesh_io.h"

namespace mscomp {
namespace {

using namespace cases;
const std::string kFolder = MSCOMP_SHARED_DIR "/reference/acap-bar/";

/// Row `row` of their text file: V matrices 3x3, row by row.
std::vector<Matrix3d> read_row(const std::string& name, int row, int vertex_count) {
    std::ifstream file(kFolder + name);
    std::string line;
    for (int i = 0; i <= row; ++i) std::getline(file, line);
    std::istringstream numbers(line);
    std::vector<Matrix3d> matrices(at(vertex_count));
    for (Matrix3d& m : matrices) {
        for (int k = 0; k < 9; ++k) numbers >> m(k / 3, k % 3);
    }
    EXPECT_TRUE(numbers) << name << " is shorter than expected";
    return matrices;
}

class AuthorsBar : public testing::Test {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(kFolder)) GTEST_SKIP() << kFolder << " is not there";
        reference_ = read_mesh(kFolder + "1.obj");
        const TriangleMesh shape = read_mesh(kFolder + "2.obj");
        set_ = extract_features(sequence_of({reference_, shape}), reference_.vertices,
                                {EdgeWeights::authors, false});
    }
    TriangleMesh reference_;
    FeatureSet set_;
};

TEST_F(AuthorsBar, StretchIsTheirs) {
    for (int row = 0; row < 2; ++row) {
        const auto truth = read_row("S_withopt_GT.txt", row, reference_.vertex_count());
        double worst = 0;
        for (int i = 0; i < reference_.vertex_count(); ++i) {
            worst = std::max(worst, largest(stretch(set_, i, row) - truth[at(i)]));
        }
        EXPECT_LE(worst, 2e-5) << "row " << row;
    }
}

// Their matrices are skew: log(2,1) log(0,2) log(1,0) are r_x r_y r_z.
TEST_F(AuthorsBar, RotationIsTheirs) {
    for (int row = 0; row < 2; ++row) {
        const auto truth = read_row("LOGRNEW_withopt_GT.txt", row, reference_.vertex_count());
        double worst = 0;
        for (int i = 0; i < reference_.vertex_count(); ++i) {
            const Matrix3d& log = truth[at(i)];
            const Vector3d theirs(log(2, 1), log(0, 2), log(1, 0));
            worst =
                std::max(worst, largest(exp_of(rotation_vector(set_, i, row)) - exp_of(theirs)));
        }
        EXPECT_LE(worst, 1e-4) << "row " << row;
    }
}

TEST_F(AuthorsBar, IsAsConsistentAsTheirs) {
    EXPECT_NEAR(set_.consistency_energy[0], 0, 1e-20);
    EXPECT_LE(set_.consistency_energy[1], 19.77);
    EXPECT_LE(set_.largest_jump[1], 0.64);
    EXPECT_NEAR(set_.consistency_gap[1], 0, 1e-6);
}

TEST_F(AuthorsBar, ReferenceHasItsOwnFeature) {
    for (int i = 0; i < reference_.vertex_count(); ++i) {
        for (int k = 0; k < kFeatureDim; ++k) {
            EXPECT_NEAR(feature(set_, i)[k], kReferenceFeature[at(k)], 1e-6);
        }
    }
}

}  // namespace
}  // namespace mscomp
