// SPDX-License-Identifier: MIT
// Training on more features than memory shall hold.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/feature_scaler.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/random.h"
#include "nn/lane_batch.h"
#include "shapes.h"

namespace mscomp {
namespace {

constexpr int kShapes = 2400;

/// Features of 221 MB and vertices of 74 MB: a sphere with one bump that comes and goes.
void write_bumps(const std::string& path) {
    FeatureSet outline;
    outline.reference = shapes::icosphere(4);
    for (int m = 0; m < kShapes; ++m) {
        outline.names.push_back("shape_" + std::to_string(m));
        outline.rotation.push_back({1, 0, 0, 0, 1, 0, 0, 0, 1});
        outline.translation.push_back({0, 0, 0});
    }
    FeatureFileWriter writer(path, outline);
    std::vector<float> features, vertices;
    for (int m = 0; m < kShapes; ++m) {
        features.clear();
        vertices.clear();
        for (const Point& p : outline.reference.vertices) {
            std::array<float, kFeatureDim> feature = kReferenceFeature;
            feature[0] = static_cast<float>(std::sin(0.1 * m) * std::max(0.0, p[0] - 0.8));
            features.insert(features.end(), feature.begin(), feature.end());
            for (const double x : p) vertices.push_back(static_cast<float>(x));
        }
        writer.put_features(m, features);
        writer.put_vertices(m, vertices);
    }
    writer.finish(outline);
}

/// The last "peak memory N MiB" of a log, in bytes.
double logged_peak(const std::string& log) {
    const std::string label = "peak memory ";
    const std::size_t at = log.rfind(label);
    EXPECT_NE(at, std::string::npos) << log;
    if (at == std::string::npos) return NAN;
    return std::strtod(log.c_str() + at + label.size(), nullptr) * 1024 * 1024;
}

TEST(MscompMemory, DoesNotGrowWithTheNumberOfShapes) {
    const TemporaryFolder folder;
    write_bumps(folder / "f.safetensors");
    folder.put("c.yaml",
               "model: {kind: stacked-attention, levels: [{components: 3, sparsity_range: 0.3}]}\n"
               "data: {features: f.safetensors}\n"
               "train: {epochs: 1, batch: 16, start: random}\n");
    const std::string line = "cd '" + folder.path() + "' && " + MSCOMP_BIN_DIR +
                             "/mscomp train c.yaml -o run --threads 2 >out 2>err";
    const int status = std::system(line.c_str());
    ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << read_file(folder / "err");
    const auto size = static_cast<double>(std::filesystem::file_size(folder / "f.safetensors"));
    EXPECT_GT(size, 290e6);
    const double peak = logged_peak(read_file(folder / "run/log.txt"));
    EXPECT_TRUE(peak < size / 3) << peak << " of " << size;
    EXPECT_GT(peak, 1e6);
}

// What the network is given is, bit for bit, what the scaler makes of the features.
TEST(ScaledFeatures, AreWhatTheScalerGives) {
    FeatureSet set;
    set.reference = shapes::icosphere(1);
    set.names = {"a", "b", "c"};
    const CounterRandom random(7, 1);
    const int vertices = set.vertex_count();
    for (int i = 0; i < 3 * vertices * kFeatureDim; ++i) {
        set.features.push_back(
            static_cast<float>(4 * random.uniform(static_cast<std::uint64_t>(i)) - 2));
    }
    nn::VertexOrder order;
    order.to_user.resize(static_cast<std::size_t>(vertices));
    std::iota(order.to_user.begin(), order.to_user.end(), 0);
    order.to_internal = order.to_user;
    const MemoryFeatures memory(set.features, vertices);
    for (const FeatureCenter center : {FeatureCenter::reference, FeatureCenter::minmax}) {
        const auto scaler = FeatureScaler::fit(set, std::vector{0, 1, 2}, center);
        std::vector<float> rows(static_cast<std::size_t>(vertices * kFeatureDim * 8));
        nn::gather_lanes({memory, scaler.offset, scaler.factor}, std::vector{2, 0}, order,
                         std::span<float>(rows), nn::GatherThreads::all);
        for (const auto& [lane, shape] : {std::pair(0, 2), std::pair(1, 0)}) {
            const std::span<const float> raw = set.shape(shape);
            std::vector<float> scaled(raw.begin(), raw.end());
            scaler.scale(scaled);
            for (std::size_t i = 0; i < scaled.size(); ++i) {
                ASSERT_EQ(rows[i * 8 + static_cast<std::size_t>(lane)], scaled[i]);
            }
        }
    }
}

}  // namespace
}  // namespace mscomp
