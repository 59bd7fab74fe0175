// SPDX-License-Identifier: MIT
// mscomp run as a user runs it: trained, stopped, killed, resumed, exported, and with bad input.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Twelve shapes of a sphere on which two patches turn independently.
FeatureSet patches_on_a_sphere() {
    FeatureSet set;
    set.reference = shapes::icosphere(2);
    const CounterRandom random(3, 0);
    const std::array<int, 2> centers{0, 3};
    for (int m = 0; m < 12; ++m) {
        set.names.push_back("shape_" + std::to_string(m));
        set.rotation.push_back({1, 0, 0, 0, 1, 0, 0, 0, 1});
        set.translation.push_back({0, 0, 0});
        for (const Point& p : set.reference.vertices) {
            std::array<float, kFeatureDim> feature = kReferenceFeature;
            for (std::size_t k = 0; k < centers.size() && m > 0; ++k) {
                const Point& c = set.reference.vertices[static_cast<std::size_t>(centers[k])];
                const double cosine = p[0] * c[0] + p[1] * c[1] + p[2] * c[2];
                const double code = random.normal(static_cast<std::uint64_t>(2 * m) + k);
                feature[k] = static_cast<float>(code * std::max(0.0, cosine - 0.6));
            }
            set.features.insert(set.features.end(), feature.begin(), feature.end());
            for (const double x : p) set.vertices.push_back(static_cast<float>(x));
        }
    }
    return set;
}

struct Outcome {
    int code = -1;
    std::string out, err;
};

class Mscomp : public testing::Test {
  protected:
    Mscomp() {
        fs::create_directories(folder_);
        write_features(path("set.safetensors"), patches_on_a_sphere());
        write_file(path("config.yaml"),
                   "model: {kind: stacked-attention, levels: [{components: 2, sparsity_range: "
                   "0.3}, {components: 2, "
                   "sparsity_range: 0.2}]}\n"
                   "data: {features: set.safetensors, split: {train: every, step: 2}}\n"
                   "train: {epochs: 12, batch: 4, checkpoint_every: 3}\n");
    }

    std::string path(const std::string& name) const { return folder_ + "/" + name; }

    Outcome shell(const std::string& command) const {
        const std::string line = "cd '" + folder_ + "' && ( " + command + " ) >'" + folder_ +
                                 ".out' 2>'" + folder_ + ".err'";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(folder_ + ".out"), read_file(folder_ + ".err")};
    }
    Outcome mscomp(const std::string& arguments) const {
        return shell(std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments);
    }
    void expect_ok(const Outcome& outcome) const { EXPECT_EQ(outcome.code, 0) << outcome.err; }
    std::string checkpoint(const std::string& run) const {
        return read_file(path(run + "/checkpoint.safetensors"));
    }

    TemporaryFolder temporary_;
    std::string folder_ = temporary_ / "work";
};

TEST_F(Mscomp, TrainsExportsAndReconstructs) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    for (const char* name : {"checkpoint.safetensors", "config.yaml", "metrics.csv", "log.txt"}) {
        EXPECT_TRUE(fs::exists(path(std::string("run/") + name))) << name;
    }
    const std::string metrics = read_file(path("run/metrics.csv"));
    EXPECT_THAT(metrics, testing::StartsWith("epoch,step,total,level0_reconstruction,"));
    EXPECT_EQ(std::count(metrics.begin(), metrics.end(), '\n'), 1 + 12);

    const Outcome info = mscomp("info run --json");
    expect_ok(info);
    const auto report = nlohmann::json::parse(info.out);
    EXPECT_EQ(report.at("epochs"), 12);
    EXPECT_EQ(report.at("train_shapes"), 6);
    EXPECT_EQ(report.at("levels").size(), 2);

    expect_ok(mscomp("export-components run -o components --quiet --all"));
    const auto list = nlohmann::json::parse(read_file(path("components/components.json")));
    ASSERT_EQ(list.at("components").size(), 2u + 4u);
    for (const auto& component : list.at("components")) {
        for (const char* key :
             {"id", "level", "parent", "center_vertex", "strength", "kept", "reason", "code_min",
              "code_max", "support", "localization_radius"}) {
            EXPECT_TRUE(component.contains(key)) << key;
        }
        const TriangleMesh mesh =
            read_mesh(path("components/" + component.at("file").get<std::string>()));
        EXPECT_EQ(mesh.vertex_count(), 162);
    }
    EXPECT_THAT(read_file(path("components/overview.png")), testing::StartsWith("\x89PNG"));
    EXPECT_TRUE(list.at("stance").at("up_guessed").get<bool>());
    for (const auto& component : list.at("components")) {
        EXPECT_GT(component.at("largest_displacement").get<double>(), 0);
        EXPECT_TRUE(component.at("near_empty").is_boolean());
        EXPECT_TRUE(component.at("seen_from").contains("azimuth"));
    }
    expect_ok(mscomp("export-components run -o turned --quiet --up=-z --view 30,10"));
    const auto turned = nlohmann::json::parse(read_file(path("turned/components.json")));
    EXPECT_EQ(turned.at("stance").at("up"), "-z");
    for (const auto& component : turned.at("components")) {
        if (component.at("file").is_null()) continue;
        EXPECT_EQ(component.at("seen_from").at("azimuth"), 30);
    }
    const Outcome wrong = mscomp("export-components run -o wrong --view sideways");
    EXPECT_EQ(wrong.code, 2);
    EXPECT_THAT(wrong.err, testing::HasSubstr("--view: got 'sideways', wanted front, back"));
    EXPECT_FALSE(fs::exists(path("wrong")));

    const Outcome decoded =
        mscomp("reconstruct run set.safetensors -o decoded --split test --json --quiet");
    expect_ok(decoded);
    EXPECT_EQ(nlohmann::json::parse(decoded.out).at("shapes"), 6);
    EXPECT_TRUE(fs::exists(path("decoded/shape_1.obj")));
    EXPECT_FALSE(fs::exists(path("decoded/shape_2.obj")));
}

// The model file needs nothing beside it: neither the features nor the rest of the run folder.
TEST_F(Mscomp, ExportsFromTheModelFileAlone) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    fs::rename(path("run/checkpoint.safetensors"), path("model.safetensors"));
    fs::remove_all(path("run"));
    fs::remove(path("set.safetensors"));
    expect_ok(mscomp("export-components model.safetensors -o components --quiet"));
}

TEST_F(Mscomp, ThreadsDoNotChangeABitOfTheCheckpoint) {
    expect_ok(mscomp("train config.yaml -o one --quiet --threads 1"));
    expect_ok(mscomp("train config.yaml -o two --quiet --threads 2"));
    expect_ok(mscomp("train config.yaml -o seven --quiet --threads 7"));
    EXPECT_TRUE(checkpoint("one") == checkpoint("two"));
    EXPECT_TRUE(checkpoint("one") == checkpoint("seven"));
}

// Killed without warning and resumed ends in the same bytes as a run that was left alone.
TEST_F(Mscomp, KilledAndResumedIsUninterrupted) {
    const std::string arguments = "train config.yaml --quiet --threads 1 --set train.epochs=300";
    expect_ok(mscomp(arguments + " -o whole"));
    const Outcome killed = shell(std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments +
                                 " -o killed & pid=$!\n"
                                 "until [ -e killed/checkpoint.safetensors ]; do sleep 0.01; done\n"
                                 "sleep 0.1; kill -KILL $pid; wait $pid");
    EXPECT_EQ(killed.code, 128 + 9) << "it ended before it was killed";
    expect_ok(mscomp(arguments + " -o killed --resume"));
    EXPECT_TRUE(checkpoint("killed") == checkpoint("whole"));
    const std::string metrics = read_file(path("killed/metrics.csv"));
    EXPECT_EQ(std::count(metrics.begin(), metrics.end(), '\n'), 1 + 300);
}

TEST_F(Mscomp, CtrlCSavesAndSaysHowToGoOn) {
    const std::string arguments = "train config.yaml --quiet --threads 1 --set train.epochs=100000";
    const Outcome stopped = shell(std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments +
                                  " -o run & pid=$!\n"
                                  "until [ -e run/checkpoint.safetensors ]; do sleep 0.01; done\n"
                                  "kill -INT $pid; wait $pid");
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_THAT(stopped.err, HasSubstr("--resume"));
    const auto report = nlohmann::json::parse(mscomp("info run --json").out);
    const int epochs = report.at("epochs");
    EXPECT_GT(epochs, 0);
    expect_ok(mscomp("train config.yaml -o run --quiet --resume --set train.epochs=" +
                     std::to_string(epochs + 2)));
    EXPECT_EQ(nlohmann::json::parse(mscomp("info run --json").out).at("epochs"), epochs + 2);
}

TEST_F(Mscomp, AnUnknownKeyNamesPlaceAndNearestKey) {
    write_file(path("bad.yaml"), "data: {features: set.safetensors}\ntrain:\n  epoch: 3\n");
    const Outcome outcome = mscomp("train bad.yaml -o run");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("bad.yaml:3:3"));
    EXPECT_THAT(outcome.err, HasSubstr("epochs"));
    EXPECT_FALSE(fs::exists(path("run")));
}

TEST_F(Mscomp, RefusesAnExistingRunWithoutForce) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    const std::string before = checkpoint("run");
    const Outcome outcome = mscomp("train config.yaml -o run --set train.epochs=1");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("--force"));
    EXPECT_TRUE(checkpoint("run") == before);
    expect_ok(mscomp("train config.yaml -o run --quiet --force --set train.epochs=1"));
    EXPECT_FALSE(checkpoint("run") == before);
}

TEST_F(Mscomp, RefusesToResumeUnderAnotherConfiguration) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    const std::string before = checkpoint("run");
    const Outcome outcome = mscomp("train config.yaml -o run --resume --set loss.sparsity=7");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("another configuration"));
    EXPECT_TRUE(checkpoint("run") == before);
}

TEST_F(Mscomp, RefusesToResumeOnOtherFeatures) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    FeatureSet other = patches_on_a_sphere();
    other.features[2000] += 0.1F;
    write_features(path("set.safetensors"), other);
    const Outcome outcome = mscomp("train config.yaml -o run --resume --set train.epochs=20");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("other features"));
}

TEST_F(Mscomp, RefusesATruncatedOrAlteredCheckpoint) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    const std::string file = path("run/checkpoint.safetensors");
    const std::string whole = read_file(file);
    std::string altered = whole;
    altered[altered.size() - 100] = static_cast<char>(altered[altered.size() - 100] ^ 1);
    for (const std::string& broken : {whole.substr(0, whole.size() / 2), altered, std::string()}) {
        write_file(file, broken);
        for (const char* command : {"train config.yaml -o run --resume --set train.epochs=20",
                                    "info run", "export-components run -o components"}) {
            const Outcome outcome = mscomp(command);
            EXPECT_EQ(outcome.code, 6) << command << ": " << outcome.err;
            EXPECT_THAT(outcome.err, HasSubstr("run/checkpoint.safetensors"));
        }
        EXPECT_TRUE(read_file(file) == broken) << "the evidence was overwritten";
        EXPECT_FALSE(fs::exists(path("components")));
    }
}

// No file may grow beyond 20 blocks, as on a full disk: the last good checkpoint stays, nothing
// half-written is left.
TEST_F(Mscomp, AFullDiskKeepsTheLastCheckpoint) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    const std::string before = checkpoint("run");
    const Outcome outcome =
        shell("ulimit -f 20; exec " + std::string(MSCOMP_BIN_DIR) +
              "/mscomp train config.yaml -o run --quiet --resume --set train.epochs=20");
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("File too large"));
    EXPECT_TRUE(checkpoint("run") == before);
    for (const auto& entry : fs::directory_iterator(path("run"))) {
        const std::string name = entry.path().filename();
        EXPECT_TRUE(name == "checkpoint.safetensors" || name == "config.yaml" ||
                    name == "log.txt" || name == "metrics.csv" || name == ".lock")
            << name;
    }
    expect_ok(mscomp("train config.yaml -o run --quiet --resume --set train.epochs=20"));
}

TEST_F(Mscomp, RefusesFeaturesOfAnotherMesh) {
    expect_ok(mscomp("train config.yaml -o run --quiet"));
    FeatureSet other = patches_on_a_sphere();
    std::swap(other.reference.faces[0], other.reference.faces[1]);
    write_features(path("other.safetensors"), other);
    const Outcome outcome = mscomp("reconstruct run other.safetensors -o decoded");
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr("other.safetensors"));
    EXPECT_FALSE(fs::exists(path("decoded")));
}

TEST_F(Mscomp, SaysWhereARunIsMissing) {
    const Outcome outcome = mscomp("info nowhere");
    EXPECT_EQ(outcome.code, 4);
    EXPECT_THAT(outcome.err, HasSubstr("nowhere"));
}

}  // namespace
}  // namespace mscomp
