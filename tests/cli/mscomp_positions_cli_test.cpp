// SPDX-License-Identifier: MIT
// A method on positions goes through every command as the networks do, for one file and one row in
// the table of kinds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/generate/generate.h"
#include "run/run_cases.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class PcaCommands : public testing::Test {
  protected:
    PcaCommands() {
        cases::extracted_arm(folder_ / "arm.safetensors", 11);
        run("mscomp init pca > pca.yaml");
        run("mscomp train pca.yaml -o pca.run --set data.features=arm.safetensors "
            "--set 'data.split={train: every, step: 2}'");
    }
    /// What a command prints, which has to succeed.
    std::string run(const std::string& command) const {
        const std::string line = "cd '" + folder_.path() + "' && PATH='" + MSCOMP_BIN_DIR +
                                 "':$PATH && (" + command + ") 2>err >out";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command << "\n"
                                                                   << read_file(folder_ / "err");
        return read_file(folder_ / "out");
    }

    TemporaryFolder folder_;
};

// Five directions of six training shapes; the reference is a training shape, so both fits bring it
// back, and unseen shapes are no farther by their vertices than as encoded.
TEST_F(PcaCommands, TrainsAndEvaluates) {
    const json info = json::parse(run("mscomp info pca.run --json"));
    EXPECT_EQ(info["kind"], "pca");
    EXPECT_EQ(info["levels"][0]["components"], 5);
    const json train = json::parse(run("mscomp evaluate pca.run --split train --quiet --json"));
    EXPECT_LT(train["features"]["rms_error"].get<double>(), 1e-2);
    EXPECT_LT(train["vertices"]["rms_error"].get<double>(), 1e-2);
    const json test = json::parse(
        run("mscomp evaluate pca.run --quiet --json --components 1,5 --handles 4 -o measures"));
    const double encoded = test["features"]["rms_error"];
    EXPECT_GT(encoded, 0);
    EXPECT_LE(test["vertices"]["rms_error"].get<double>(), encoded * (1 + 1e-9));
    EXPECT_TRUE(test["features"]["relative_squared_error_max"].is_null());
    EXPECT_EQ(test["features"]["support_mean"], 1);
    EXPECT_GE(test["features"]["by_components"][0]["rms_error"].get<double>(),
              test["features"]["by_components"][1]["rms_error"].get<double>());
    EXPECT_TRUE(fs::exists(folder_ / "measures/errors.png"));
}

// Where a component acts is seen in the features of the shape that it makes: here a bulge at one
// end, which is all that moves, beside a truth that lies at the other.
TEST_F(PcaCommands, LieWhereTheTruthDoes) {
    GeneratedSequence set = generate_arm(6, 0, 300);
    const std::vector<Point> rest = set.sequence.shapes.front();
    set.component_names = {"elsewhere", "bulge"};
    set.scales = {1, 1};
    set.weights.clear();
    set.supports.clear();
    for (const double height : {1.0, 11.0}) {
        for (const Point& p : rest) {
            set.supports.push_back(static_cast<float>(std::exp(-std::pow(p[2] - height, 2))));
        }
    }
    const auto bulge = std::span<const float>(set.supports).subspan(rest.size());
    for (int n = 0; n < 6; ++n) {
        set.weights.insert(set.weights.end(), {n == 3 ? 1.0F : 0.0F, static_cast<float>(n)});
        std::vector<Point>& shape = set.sequence.shapes[at(n)] = rest;
        for (std::size_t v = 0; v < rest.size(); ++v) {
            for (const std::size_t axis : {0U, 1U}) {
                shape[v][axis] *= 1 + 0.05 * n * static_cast<double>(bulge[v]);
            }
        }
    }
    write_generated(set, folder_ / "bulge");
    run("acapfeat extract bulge -o bulge.safetensors --no-align --quiet");
    run("mscomp train pca.yaml -o bulge.run --quiet --set data.features=bulge.safetensors "
        "--set data.split.train=all");
    const json truth = json::parse(run("mscomp evaluate bulge.run --truth bulge/truth.json --fit "
                                       "features --quiet --json"))
                           .at("truth");
    const json& found = truth["by_overlap"]["list"];
    EXPECT_EQ(found[1]["component"], "0");
    EXPECT_GT(found[1]["iou"], 0.75);
    EXPECT_GT(found[1]["soft_iou"], 0.6);
    EXPECT_LT(found[0]["iou"], 0.5);
    EXPECT_GT(truth["features"]["list"][1]["best"]["correlation"], 0.999);
    EXPECT_TRUE(truth["by_overlap"]["fine"]["at_scale"].is_null()) << "of one level";
}

// Where codes do not decode to features there are no joint codes to fit to them.
TEST_F(PcaCommands, AllFitsAreThoseWithoutFeatures) {
    json all = json::parse(run("mscomp evaluate pca.run --quiet --json --fit all"));
    EXPECT_FALSE(all.contains("codes"));
    EXPECT_EQ(all, json::parse(run("mscomp evaluate pca.run --quiet --json --fit both")));
    for (const char* command : {"evaluate pca.run --fit codes",
                                "reconstruct pca.run arm.safetensors -o decoded --fit codes"}) {
        run(std::string("! mscomp ") + command + " --quiet 2>message");
        EXPECT_THAT(read_file(folder_ / "message"),
                    HasSubstr("--fit codes: a model of kind pca decodes to positions"));
    }
    EXPECT_FALSE(fs::exists(folder_ / "decoded"));
}

TEST_F(PcaCommands, ExportsBothEndsOfEveryComponent) {
    run("mscomp export-components pca.run -o components --quiet");
    const json list = json::parse(read_file(folder_ / "components/components.json"));
    ASSERT_EQ(list["components"].size(), 5U);
    for (const json& component : list["components"]) {
        EXPECT_EQ(component["support"], 1);
        if (component["file"].is_null()) continue;
        EXPECT_TRUE(fs::exists(folder_ / ("components/" + component["file"].get<std::string>())));
    }
    EXPECT_FALSE(list["components"][0]["file"].is_null());
    EXPECT_TRUE(fs::exists(folder_ / "components/overview.png"));
}

TEST_F(PcaCommands, SynthesizesSamplesAndReconstructs) {
    run("mscomp synthesize pca.run --weight 0=1 -o end.obj --quiet");
    run("mscomp synthesize pca.run --weight 0=0 -o none.obj --quiet");
    run("mscomp synthesize pca.run --sheet sheet.png --quiet");
    const TriangleMesh none = read_mesh(folder_ / "none.obj"), end = read_mesh(folder_ / "end.obj");
    const FeatureFile file(folder_ / "arm.safetensors");
    double still = 0, moved = 0;
    for (std::size_t v = 0; v < none.vertices.size(); ++v) {
        for (std::size_t x = 0; x < 3; ++x) {
            const double rest = file.outline().reference.vertices[v][x];
            still = std::max(still, std::abs(none.vertices[v][x] - rest));
            moved = std::max(moved, std::abs(end.vertices[v][x] - rest));
        }
    }
    EXPECT_LT(still, 1e-5);
    EXPECT_GT(moved, 0.05);
    run("mscomp sample pca.run -n 2 -o samples --quiet");
    EXPECT_TRUE(fs::exists(folder_ / "samples/sample_1.obj"));
    EXPECT_THAT(run("mscomp reconstruct pca.run arm.safetensors -o decoded --quiet"),
                HasSubstr("E_rms"));
}

// Keys that mean nothing to it are keys of other kinds.
TEST_F(PcaCommands, HasNoKeysOfNetworks) {
    const std::string text = read_file(folder_ / "pca.yaml");
    EXPECT_THAT(text, HasSubstr("components: 50"));
    EXPECT_THAT(text, testing::Not(HasSubstr("learning_rate")));
    EXPECT_THAT(text, testing::Not(HasSubstr("loss:")));
}

}  // namespace
}  // namespace mscomp
