// SPDX-License-Identifier: MIT
// mscomp export-components, synthesize and sample on runs of every kind.
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

/// Ten shapes of a sphere on which two opposite patches turn independently.
FeatureSet two_patches() {
    FeatureSet set;
    set.reference = shapes::icosphere(2);
    const CounterRandom random(3, 0);
    for (int m = 0; m < 10; ++m) {
        set.names.push_back("shape_" + std::to_string(m));
        set.rotation.push_back({1, 0, 0, 0, 1, 0, 0, 0, 1});
        set.translation.push_back({0, 0, 0});
        for (const Point& p : set.reference.vertices) {
            std::array<float, kFeatureDim> feature = kReferenceFeature;
            for (std::size_t k = 0; k < 2 && m > 0; ++k) {
                const double height = k == 0 ? p[2] : -p[2];
                const double code = random.normal(static_cast<std::uint64_t>(2 * m) + k);
                feature[k] = static_cast<float>(code * std::max(0.0, height - 0.6));
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

class SynthesisCommands : public testing::TestWithParam<const char*> {
  protected:
    SynthesisCommands() {
        fs::create_directories(folder_);
        write_features(path("set.safetensors"), two_patches());
    }

    std::string path(const std::string& name) const { return folder_ + "/" + name; }
    Outcome mscomp(const std::string& arguments) const {
        const std::string line = "cd '" + folder_ + "' && " + MSCOMP_BIN_DIR + "/mscomp " +
                                 arguments + " >'" + folder_ + ".out' 2>'" + folder_ + ".err'";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(folder_ + ".out"), read_file(folder_ + ".err")};
    }
    void expect_ok(const Outcome& outcome) const { EXPECT_EQ(outcome.code, 0) << outcome.err; }
    void expect_refused(const std::string& arguments, const std::string& words) const {
        const Outcome outcome = mscomp(arguments);
        EXPECT_EQ(outcome.code, 2) << arguments << ": " << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(words)) << arguments;
    }
    /// run.run of this kind with a few components.
    void train(const std::string& kind) const {
        std::string model = "{kind: " + kind + ", ";
        if (kind == "spectral-vae") model += "components: 4}";
        if (kind == "autoencoder") model += "components: 3, sparsity_range: 0.3}";
        if (kind == "stacked-attention") {
            model +=
                "levels: [{components: 2, sparsity_range: 0.3}, {components: 2, "
                "sparsity_range: 0.2}]}";
        }
        write_file(
            path("config.yaml"),
            "model: " + model + "\ndata: {features: set.safetensors}\ntrain: {epochs: 40}\n");
        expect_ok(mscomp("train config.yaml -o run --quiet"));
    }
    /// W that moves a component to its other end; 0 where it has none.
    static std::string weight_of_other_end(const nlohmann::json& c) {
        const double reference = c.at("code_reference"), end = c.at("code_end"),
                     other = c.at("code_other");
        return nlohmann::json(end == reference ? 0.0 : (other - reference) / (end - reference))
            .dump();
    }
    static void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
        ASSERT_EQ(a.vertex_count(), b.vertex_count());
        for (std::size_t v = 0; v < a.vertices.size(); ++v) {
            for (std::size_t i = 0; i < 3; ++i) {
                EXPECT_NEAR(a.vertices[v][i], b.vertices[v][i], 1e-5);
            }
        }
    }
    nlohmann::json json(const std::string& arguments) const {
        const Outcome outcome = mscomp(arguments);
        expect_ok(outcome);
        return nlohmann::json::parse(outcome.out, nullptr, false);
    }

    TemporaryFolder temporary_;
    std::string folder_ = temporary_ / "work";
};

// What the export writes of each component is what synthesize makes at weight 1, byte for byte, on
// every level; both ends are written, in order of the distance of the end.
TEST_P(SynthesisCommands, ExportBothEndsInOrderAndMakeThemAgain) {
    train(GetParam());
    expect_ok(mscomp("export-components run -o components --quiet --all"));
    const auto list = nlohmann::json::parse(read_file(path("components/components.json")));
    ASSERT_GE(list.at("components").size(), 3U);
    nlohmann::json before;
    for (const auto& c : list.at("components")) {
        if (!before.is_null() && before.at("level") == c.at("level")) {
            EXPECT_GE(before.at("distance"), c.at("distance"));
        }
        before = c;
        const std::string id = c.at("id"), file = c.at("file"), other = c.at("other_file");
        EXPECT_TRUE(c.at("code_end") == c.at("code_min") || c.at("code_end") == c.at("code_max"));
        EXPECT_TRUE(c.at("code_other") == c.at("code_min") ||
                    c.at("code_other") == c.at("code_max"));
        expect_ok(mscomp("synthesize run --weight " + id + "=1 -o new.ply --quiet --force"));
        EXPECT_TRUE(read_file(path("new.ply")) == read_file(path("components/" + file))) << id;
        expect_ok(mscomp("synthesize run --weight " + id + "=" + weight_of_other_end(c) +
                         " -o other.ply --quiet --force"));
        expect_same(read_mesh(path("other.ply")), read_mesh(path("components/" + other)));
    }
}

// Another export into the same folder leaves nothing of the earlier one.
TEST_P(SynthesisCommands, ExportAgainRemovesBothEndsOfTheEarlierOne) {
    train(GetParam());
    expect_ok(mscomp("export-components run -o components --quiet --all"));
    EXPECT_TRUE(fs::exists(path("components/level0_0_other.ply")));
    expect_ok(
        mscomp("train config.yaml -o run --quiet --force --set filter.rule=strength "
               "--set filter.minimum_strength=100"));
    expect_ok(mscomp("export-components run -o components --quiet --force"));
    for (const auto& entry : fs::directory_iterator(path("components"))) {
        EXPECT_NE(entry.path().extension(), ".ply") << entry.path();
    }
}

TEST_P(SynthesisCommands, WeightZeroIsTheReference) {
    train(GetParam());
    const auto report = json("synthesize run --weight 0=0 1=0 -o new.obj --json --quiet");
    EXPECT_EQ(report.at("files"), nlohmann::json::array({"new.obj"}));
    expect_same(read_mesh(path("new.obj")), shapes::icosphere(2));
}

// Weights of several components are those of the report; the others keep the reference's code.
TEST_P(SynthesisCommands, MixComponents) {
    train(GetParam());
    const auto list = json("synthesize run --list --json");
    const auto report =
        json("synthesize run --weight 0=0.5 --weight 1=-0.25 -o new.off --json --quiet");
    for (const auto& c : list) {
        const std::string id = c.at("id");
        if (c.at("merged_into") == "0" || c.at("merged_into") == "1") continue;
        const double w = id == "0" ? 0.5 : id == "1" ? -0.25 : 0;
        const double reference = c.at("code_reference"), end = c.at("code_end");
        EXPECT_NEAR(report.at("codes").at(id).get<double>(), reference + w * (end - reference),
                    1e-6);
    }
    EXPECT_EQ(read_mesh(path("new.off")).vertex_count(), 162);
}

TEST_P(SynthesisCommands, DrawSheets) {
    train(GetParam());
    const auto report = json("synthesize run --sheet a.png --strongest 2 --tile 64 --json --quiet");
    EXPECT_EQ(report.at("sheet_components").size(), 2U);
    EXPECT_EQ(report.at("sheet_weights"), nlohmann::json::array({0.3, 0.7, 1.1}));
    EXPECT_THAT(read_file(path("a.png")), testing::StartsWith("\x89PNG"));
    const auto named = json(
        "synthesize run --sheet b.png --component 1 0 --weights -1,1 --tile 64 --json --quiet");
    EXPECT_EQ(named.at("sheet_components"), nlohmann::json::array({"1", "0"}));
    EXPECT_EQ(named.at("sheet_weights"), nlohmann::json::array({-1.0, 1.0}));
}

TEST_P(SynthesisCommands, SampleTheSameShapesForTheSameSeed) {
    train(GetParam());
    const auto report = json("sample run -n 3 -o a --seed 5 --tile 64 --json --quiet");
    EXPECT_EQ(report.at("files").size(), 3U);
    expect_ok(mscomp("sample run -n 3 -o b --seed 5 --tile 64 --quiet --threads 2"));
    expect_ok(mscomp("sample run -n 3 -o c --seed 6 --tile 64 --quiet"));
    for (const char* name : {"sample_0.obj", "sample_2.obj", "codes.csv", "overview.png"}) {
        const std::string a = read_file(path(std::string("a/") + name));
        EXPECT_TRUE(a == read_file(path(std::string("b/") + name))) << name;
        EXPECT_FALSE(a == read_file(path(std::string("c/") + name))) << name;
    }
    const std::string table = read_file(path("a/codes.csv"));
    EXPECT_THAT(table, testing::StartsWith("sample,0,1,"));
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 3);
    expect_ok(mscomp("sample run -n 2 -o d --from fitted --independent --format ply --quiet"));
    EXPECT_EQ(read_mesh(path("d/sample_1.ply")).vertex_count(), 162);
}

// Only variational autoencoders are trained towards N(0, I).
TEST_P(SynthesisCommands, OnlyVariationalModelsHaveAPrior) {
    train(GetParam());
    if (std::string(GetParam()) == "spectral-vae") {
        EXPECT_EQ(json("sample run -n 1 -o a --from prior --json --quiet").at("from"), "prior");
        expect_refused("sample run -n 1 -o b --from prior --independent", "independent already");
    } else {
        expect_refused("sample run -n 1 -o a --from prior", "has no prior");
    }
}

INSTANTIATE_TEST_SUITE_P(Kinds, SynthesisCommands,
                         testing::Values("stacked-attention", "autoencoder", "spectral-vae"),
                         [](const auto& kind) {
                             std::string name = kind.param;
                             std::ranges::replace(name, '-', '_');
                             return name;
                         });

class SynthesisMistakes : public SynthesisCommands {};

TEST_F(SynthesisMistakes, AreNamed) {
    train("stacked-attention");
    expect_refused("synthesize run --weight 9.1=1 -o new.obj", "the nearest one is '");
    expect_refused("synthesize run --weight 9.1=1 -o new.obj", "--list lists all");
    expect_refused("synthesize run --sheet a.png --component 7", "there is no component '7'");
    for (const char* wrong : {"0", "0=", "0=x", "0=nan", "0=1x"}) {
        expect_refused(std::string("synthesize run -o new.obj --weight ") + wrong, "wanted ID=W");
    }
    expect_refused("synthesize run --weight 0=1 0=2 -o new.obj", "has a weight already");
    expect_refused("synthesize run --weight 0=1", "wanted -o FILE");
    expect_refused("synthesize run", "wanted -o FILE");
    expect_refused("synthesize run --weight 0=1 --sheet a.png", "go together");
    expect_refused("synthesize run --weight 0=1 -o new.stl",
                   "wanted a name that ends in .obj, .ply, .off");
    expect_refused("synthesize run --sheet a.png --level 5", "has no kept component");
    expect_refused("sample run -n 0 -o s", "not in range");
    expect_refused("sample run -n 1 -o s --seed -1", "wanted a whole number");
    EXPECT_FALSE(fs::exists(path("new.obj")));
    EXPECT_FALSE(fs::exists(path("a.png")));
    EXPECT_FALSE(fs::exists(path("s")));
    EXPECT_EQ(mscomp("synthesize nowhere --list").code, 4);
    EXPECT_EQ(mscomp("sample nowhere -o s").code, 4);
    write_file(path("new.obj"), "kept");
    expect_refused("synthesize run --weight 0=1 -o new.obj", "--force");
    EXPECT_EQ(read_file(path("new.obj")), "kept");
}

}  // namespace
}  // namespace mscomp
