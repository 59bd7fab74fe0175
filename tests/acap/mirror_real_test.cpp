// SPDX-License-Identifier: MIT
// Which real references are mirror symmetric.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mirror.h"

namespace mscomp {
namespace {

struct RealSet {
    const char* name;
    double least, most;  // of the mean distance
};

class RealMirror : public testing::TestWithParam<RealSet> {};

TEST_P(RealMirror, IsThereWhereTheReferenceIsSymmetric) {
    const auto& [name, least, most] = GetParam();
    const std::string folder = std::string(MSCOMP_SHARED_DIR "/data/") + name;
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
    const MeshSequence first = read_sequence({expand_inputs({folder}).front()});
    const TriangleMesh reference{first.shapes.front(), first.faces};
    const auto start = std::chrono::steady_clock::now();
    const std::optional<Mirror> mirror = mirror_of(reference, 1);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    ASSERT_TRUE(mirror);
    std::printf("| %s | %d | %.5f | %.2f s |\n", name, reference.vertex_count(), mirror->distance,
                seconds.count());
    EXPECT_GE(mirror->distance, least);
    EXPECT_LE(mirror->distance, most);
    EXPECT_EQ(mirror_of(reference).has_value(), most <= 0.02);
}

INSTANTIATE_TEST_SUITE_P(Sets, RealMirror,
                         testing::Values(RealSet{"people", 0, 1e-4},
                                         RealSet{"expressions", 0, 1e-4},
                                         RealSet{"camel", 0, 0.001}, RealSet{"horse", 0, 0.005},
                                         RealSet{"samba", 0, 0.011}, RealSet{"scape", 0, 0.015},
                                         RealSet{"girl", 0.03, 1}, RealSet{"hand", 0.05, 1}),
                         [](const auto& set) { return set.param.name; });

}  // namespace
}  // namespace mscomp
