// SPDX-License-Identifier: MIT
// Real sets: what their README says of them. Skipped where they are absent.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "mscomp/acap/mesh/mesh_sequence.h"

namespace mscomp {
namespace {

std::string set_folder(const std::string& name) {
    return std::string(MSCOMP_SHARED_DIR) + "/data/" + name;
}

#define SKIP_WITHOUT_SET(name)                                            \
    if (!std::filesystem::is_directory(set_folder(name))) {               \
        GTEST_SKIP() << "the set '" << set_folder(name) << "' is absent"; \
    }

struct RealSet {
    MeshSequence sequence;
    ConnectivityReport report;
};

/// Reads the set and makes sure that the rings are those of the faces.
RealSet read_set(const std::string& name) {
    RealSet set{read_sequence(expand_inputs({set_folder(name)})), {}};
    const int vertex_count = set.sequence.vertex_count();
    const SurfaceConnectivity surface = analyze_connectivity(vertex_count, set.sequence.faces);
    const OneRings expected = one_rings_of_faces(vertex_count, set.sequence.faces);
    EXPECT_EQ(surface.rings.offsets, expected.offsets);
    EXPECT_EQ(surface.rings.neighbors, expected.neighbors);
    set.report = surface.report;
    return set;
}

void expect_counts(const MeshSequence& sequence, int shapes, int vertices, std::size_t faces) {
    EXPECT_EQ(sequence.shape_count(), shapes);
    EXPECT_EQ(sequence.vertex_count(), vertices);
    EXPECT_EQ(sequence.faces.size(), faces);
}

TEST(RealSets, ScapeIsAClosedManifold) {
    SKIP_WITHOUT_SET("scape");
    const auto [sequence, report] = read_set("scape");
    expect_counts(sequence, 71, 2161, 4318);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_edges, 0);
    EXPECT_EQ(report.non_manifold_edges, 0);
    EXPECT_EQ(report.non_manifold_vertices, 0);
    EXPECT_TRUE(report.warnings.empty());
}

TEST(RealSets, HorseHasTwoBoundaryLoops) {
    SKIP_WITHOUT_SET("horse");
    const auto [sequence, report] = read_set("horse");
    expect_counts(sequence, 49, 8431, 16843);
    EXPECT_EQ(sequence.names.front(), "0000_reference");
    EXPECT_EQ(report.boundary_loops, 2);
    EXPECT_EQ(report.non_manifold_edges, 0);
}

/// Edges in more than two faces, counted in the plainest way.
int crowded_edges(const std::vector<Face>& faces) {
    std::map<std::pair<int, int>, int> counts;
    for (const Face& face : faces) {
        for (std::size_t k = 0; k < 3; ++k) {
            ++counts[std::minmax({face[k], face[(k + 1) % 3]})];
        }
    }
    return static_cast<int>(std::count_if(counts.begin(), counts.end(),
                                          [](const auto& edge) { return edge.second > 2; }));
}

TEST(RealSets, CamelIsReportedAsNotManifoldWithRepeatedFaces) {
    SKIP_WITHOUT_SET("camel");
    const auto [sequence, report] = read_set("camel");
    expect_counts(sequence, 11, 21887, 43814);
    EXPECT_EQ(crowded_edges(sequence.faces), 26);
    EXPECT_GE(report.non_manifold_edges, 26);
    EXPECT_GT(report.duplicate_faces, 0);
    EXPECT_GT(report.faces_beside, 0);
}

TEST(RealSets, GirlHasFourComponents) {
    SKIP_WITHOUT_SET("girl");
    const auto [sequence, report] = read_set("girl");
    expect_counts(sequence, 34, 1886, 3783);
    EXPECT_EQ(report.components, 4);
    EXPECT_GT(report.non_manifold_edges, 0);
}

}  // namespace
}  // namespace mscomp
