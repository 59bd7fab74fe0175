// SPDX-License-Identifier: MIT
// Leaving out the vertices where nothing acts, on real poses: the same optimum as without.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"

namespace mscomp {
namespace {

class SupportsOnScape : public testing::Test {
  protected:
    void SetUp() override {
        if (!std::filesystem::exists(shapes_ + "/frame_0001.obj")) {
            GTEST_SKIP() << "no real meshes under " << MSCOMP_SHARED_DIR;
        }
        run("acapfeat extract '" + shapes_ + "' -o scape.safetensors");
        folder_.put("c.yaml",
                    "data: {features: scape.safetensors, split: {train: random, count: 36}}\n"
                    "model: {kind: stacked-attention}\n");
    }

    void run(const std::string& command) {
        const std::string line =
            "cd '" + folder_.path() + "' && " + MSCOMP_BIN_DIR + "/" + command + " >out 2>err";
        const int status = std::system(line.c_str());
        ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
            << command << ": " << read_file(folder_ / "err");
    }

    /// Runs `all` and `active`, without and with vertices left out.
    void train_both(const std::string& settings) {
        const std::string rest =
            " --quiet --set train.epochs=200 --set train.checkpoint_every=200 " + settings;
        run("mscomp train c.yaml -o all --set train.supports=false" + rest);
        run("mscomp train c.yaml -o active" + rest);
        EXPECT_EQ(last("all", "touched"), 1.0);
    }

    /// The column of the last row of metrics.csv.
    double last(const std::string& name, const std::string& column) {
        std::istringstream rows(read_file(folder_ / (name + "/metrics.csv")));
        std::string head, row, next;
        std::getline(rows, head);
        while (std::getline(rows, next)) row = next;
        std::istringstream names(head), values(row);
        std::string value;
        while (std::getline(names, next, ',') && std::getline(values, value, ',')) {
            if (next == column) return std::stod(value);
        }
        return NAN;
    }

    std::set<std::string> kept(const std::string& name) {
        run("mscomp export-components " + name + " -o " + name + "_components --quiet --force");
        std::set<std::string> ids;
        const auto report =
            nlohmann::json::parse(read_file(folder_ / (name + "_components/components.json")));
        for (const auto& component : report.at("components")) {
            if (component.at("kept").get<bool>()) ids.insert(component.at("id").get<std::string>());
        }
        return ids;
    }

    TemporaryFolder folder_;
    const std::string shapes_ = std::string(MSCOMP_SHARED_DIR) + "/data/scape";
};

// In the paper each autoencoder has an optimum of its own.
TEST_F(SupportsOnScape, ReachTheOptimumOfAllVertices) {
    train_both(
        "--set loss.target=share --set data.metric=vertices --set model.bias=true "
        "--set model.levels[1].sparsity_range=0.2");
    EXPECT_LT(last("active", "touched"), 0.4);
    const double wanted = last("all", "total"), got = last("active", "total");
    EXPECT_TRUE(std::abs(got - wanted) <= 1e-3 * wanted) << got << " instead of " << wanted;
    EXPECT_EQ(kept("active"), kept("all"));
    EXPECT_GT(kept("all").size(), 30u);
}

// Where they answer for the sum the same shape can be shared out in many ways: another path, that
// ends no higher.
TEST_F(SupportsOnScape, AreNoWorseForTheSum) {
    train_both("--set train.fill_up_to=0");
    EXPECT_LT(last("active", "touched"), 0.45);
    const double wanted = last("all", "total"), got = last("active", "total");
    EXPECT_TRUE(got <= (1 + 1e-3) * wanted) << got << " instead of " << wanted;
}

}  // namespace
}  // namespace mscomp
