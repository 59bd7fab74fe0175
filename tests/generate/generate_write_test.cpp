// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "generated_cases.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using namespace cases;

TEST(WriteGenerated, WritesMeshesAndTheirTruth) {
    const std::string folder = testing::TempDir() + "arm_truth_test";
    std::filesystem::remove_all(folder);
    const GeneratedSequence small = generate_arm(3, 5, 400);
    write_generated(small, folder);

    const TriangleMesh mesh = read_mesh(folder + "/frame_0002.obj");
    EXPECT_EQ(mesh.faces, small.sequence.faces);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        EXPECT_LE(norm(minus(mesh.vertices[i], small.sequence.shapes[2][i])), 1e-7);
    }
    const nlohmann::json truth = nlohmann::json::parse(read_file(folder + "/truth.json"));
    EXPECT_EQ(truth["names"].get<std::vector<std::string>>(), small.component_names);
    EXPECT_EQ(truth["scales"].get<std::vector<int>>(), small.scales);
    ASSERT_EQ(truth["weights"].size(), 3u);
    EXPECT_EQ(truth["weights"][2][1].get<float>(), weight(small, 2, 1));
    const SafetensorsFile file(folder + "/truth_supports.safetensors");
    const std::span<const float> supports =
        file.data<float>("supports", {small.component_count(), small.sequence.vertex_count()});
    EXPECT_TRUE(std::equal(supports.begin(), supports.end(), small.supports.begin()));
    EXPECT_FALSE(std::filesystem::exists(folder + "/truth_rotation.safetensors"));
    std::filesystem::remove_all(folder);
}

TEST(WriteGenerated, WritesTheRotationsOfATwist) {
    const std::string folder = testing::TempDir() + "twist_truth_test";
    std::filesystem::remove_all(folder);
    for (const double tilt : {0.0, 20.0}) {
        TwistOptions options;
        options.tilt = tilt;
        const GeneratedSequence bar = generate_twist(3, 0, 100, options);
        write_generated(bar, folder);
        const SafetensorsFile file(folder + "/truth_rotation.safetensors");
        const int V = bar.sequence.vertex_count();
        const auto rotation = file.data<float>("rotation", {3, V, 3});
        EXPECT_TRUE(std::ranges::equal(rotation, bar.rotation_truth.rotation));
        EXPECT_NE(*std::ranges::max_element(rotation), 0);
        EXPECT_TRUE(
            std::ranges::equal(file.data<std::uint8_t>("exact", {V}), bar.rotation_truth.exact));
        EXPECT_EQ(file.contains("features"), tilt == 0);
        if (tilt == 0) {
            EXPECT_TRUE(std::ranges::equal(file.data<float>("features", {3, V, 9}),
                                           bar.rotation_truth.features));
        }
    }
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace mscomp
