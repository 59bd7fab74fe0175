// SPDX-License-Identifier: MIT
// check on real sets: what their README says of them, and no false alarm. Skipped where they are
// absent.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "acap/check/check_edges.h"
#include "check_cases.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

using namespace cases;

std::string set_folder(const std::string& name) {
    return std::string(MSCOMP_SHARED_DIR) + "/data/" + name;
}

class CheckRealSet : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        const std::string folder = set_folder(GetParam());
        if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is absent";
        paths_ = expand_inputs({folder});
    }
    std::vector<std::string> paths_;
};

TEST_P(CheckRealSet, HasNoErrorAndNoFalseAlarm) {
    const CheckReport report = check_meshes(paths_);
    EXPECT_EQ(report.count(Severity::error), 0);
    EXPECT_EQ(report.usable, static_cast<int>(paths_.size()));
    for (const char* kind : {"permuted_vertices", "stray_vertices", "reference_stray_vertices",
                             "mirrored_frames", "other_scale", "stretch_outlier", "far_away"}) {
        EXPECT_EQ(count_of(report, kind), 0) << kind;
    }
}

TEST_P(CheckRealSet, RenumberedVerticesAreNoticedInEveryShape) {
    const TriangleMesh reference = read_mesh(paths_.front());
    const EdgeStretchTest test(reference.vertices,
                               one_rings_of_faces(reference.vertex_count(), reference.faces));
    const int count = reference.vertex_count();
    const std::vector<int> random = CounterRandom(1, 1).permutation(count);
    for (std::size_t k = 1; k < paths_.size(); k += 1 + paths_.size() / 12) {
        const TriangleMesh shape = read_mesh(paths_[k]);
        EXPECT_FALSE(test.compare(shape.vertices).permuted) << paths_[k];
        EXPECT_TRUE(test.compare(renumbered(shape, random).vertices).permuted) << paths_[k];
        for (const int by : {1, -1, count / 2}) {
            EXPECT_TRUE(test.compare(shifted(shape, by).vertices).permuted) << paths_[k] << by;
        }
    }
}

TEST_P(CheckRealSet, FindsTwentyOfTwentyPatchesAndExchanges) {
    const TriangleMesh reference = read_mesh(paths_.front());
    const OneRings rings = one_rings_of_faces(reference.vertex_count(), reference.faces);
    const EdgeStretchTest test(reference.vertices, rings);
    const CounterRandom random(3, 1);
    for (int n = 0; n < 20; ++n) {
        const auto draw = [&](int k, std::size_t count) {
            return static_cast<int>(random.uniform(at(10 * n + k)) * static_cast<double>(count));
        };
        const std::size_t frame = 1 + at(draw(0, paths_.size() - 1));
        const TriangleMesh shape = read_mesh(paths_[frame]);
        const int first = draw(1, shape.vertices.size()), other = draw(2, shape.vertices.size());
        const std::vector<Point> patch = shuffled_patch(shape, rings, first, 50, n).vertices;
        EXPECT_TRUE(test.compare(patch).permuted) << paths_[frame] << " around " << first;
        EXPECT_TRUE(test.compare(exchanged(shape, first, other).vertices).permuted)
            << paths_[frame] << ": " << first << " and " << other;
    }
}

TEST_P(CheckRealSet, CallsNoFrameShuffled) {
    const TriangleMesh reference = read_mesh(paths_.front());
    const EdgeStretchTest test(reference.vertices,
                               one_rings_of_faces(reference.vertex_count(), reference.faces));
    for (const std::string& path : paths_) {
        EXPECT_FALSE(test.compare(read_mesh(path).vertices).permuted) << path;
    }
}

INSTANTIATE_TEST_SUITE_P(Sets, CheckRealSet,
                         testing::Values("scape", "horse", "samba", "hand", "expressions", "camel",
                                         "girl", "people"),
                         [](const auto& set) { return set.param; });

TEST(CheckRealSets, CamelIsNotManifold) {
    if (!std::filesystem::is_directory(set_folder("camel"))) GTEST_SKIP() << "camel is absent";
    const std::vector<std::string> paths = expand_inputs({set_folder("camel")});
    const CheckReport report = check_meshes(paths);
    const TriangleMesh mesh = read_mesh(paths.front());
    const ConnectivityReport expected =
        analyze_connectivity(mesh.vertex_count(), mesh.faces).report;
    EXPECT_EQ(count_of(report, "non_manifold_edges"), 26);
    EXPECT_EQ(count_of(report, "non_manifold_edges") + count_of(report, "misoriented_edges"),
              expected.non_manifold_edges);
    EXPECT_EQ(count_of(report, "duplicate_faces"), expected.duplicate_faces);
    EXPECT_GT(expected.duplicate_faces, 0);
    EXPECT_EQ(count_of(report, "non_manifold_vertices"), expected.non_manifold_vertices);
    EXPECT_EQ(count_of(report, "boundary"), expected.boundary_loops);
    EXPECT_EQ(finding(report, "non_manifold_edges").places.size(), 26u);
}

TEST(CheckRealSets, GirlHasFourPiecesAndRepeatedShapes) {
    if (!std::filesystem::is_directory(set_folder("girl"))) GTEST_SKIP() << "girl is absent";
    const std::vector<std::string> paths = expand_inputs({set_folder("girl")});
    const CheckReport report = check_meshes(paths);
    EXPECT_EQ(report.components, 4);
    EXPECT_EQ(count_of(report, "several_components"), 4);
    std::int64_t vertices = 0;
    for (const CheckPlace& piece : finding(report, "several_components").places) {
        vertices += piece.count;
    }
    EXPECT_EQ(vertices, 1886);
    std::set<std::vector<Point>> distinct;
    for (const std::string& path : paths) distinct.insert(read_mesh(path).vertices);
    EXPECT_EQ(count_of(report, "repeated_frames"),
              static_cast<std::int64_t>(paths.size() - distinct.size()));
    EXPECT_LT(distinct.size(), paths.size());
}

}  // namespace
}  // namespace mscomp
