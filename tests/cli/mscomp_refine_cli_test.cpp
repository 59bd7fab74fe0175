// SPDX-License-Identifier: MIT
// mscomp refine: one run out of another, by the command line.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/temporary_folder.h"
#include "cli/sweep_fixture.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RefineCommand : public testing::Test {
  protected:
    RefineCommand() {
        fs::create_directories(work_);
        for (const char* kind : {"autoencoder", "pca"}) {
            temporary_.put(fmt::format("work/{}.yaml", kind),
                           fmt::format("model: {{kind: {}, components: 3}}\n"
                                       "data: {{features: {}, split: {{train: every, step: 2}}}}\n",
                                       kind, arm_features()));
        }
        expect_code("train autoencoder.yaml -o first.run --quiet --set train.epochs=5", 0);
    }
    Outcome mscomp(const std::string& arguments) const { return shell(work_, mscomp_ + arguments); }
    Outcome expect_code(const std::string& arguments, int code) const {
        const Outcome outcome = mscomp(arguments);
        EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.err;
        return outcome;
    }
    std::string content(const std::string& name) const {
        return TemporaryFolder::content(work_ + "/" + name);
    }

    TemporaryFolder temporary_;
    std::string work_ = temporary_ / "work";
    std::string mscomp_ = std::string(MSCOMP_BIN_DIR) + "/mscomp ";
};

// A run like any other: every command takes it, and its configuration trains the same again.
TEST_F(RefineCommand, MakesARunLikeAnyOther) {
    const Outcome made = expect_code("refine first.run -o finer.run --quiet", 0);
    EXPECT_THAT(made.out, HasSubstr("finer.run: 4 epochs, 100 steps, loss "));
    EXPECT_THAT(content("finer.run/config.yaml"), HasSubstr("first.run"));
    EXPECT_THAT(content("finer.run/log.txt"), HasSubstr("mscomp refine first.run"));
    const auto info = nlohmann::json::parse(expect_code("info finer.run --json", 0).out);
    EXPECT_EQ(info.at("kind"), "multiscale");
    EXPECT_EQ(info.at("levels")[0].at("components"), 3);
    expect_code("evaluate finer.run --quiet", 0);
    expect_code("export-components finer.run -o parts --tile 64 --quiet", 0);
    expect_code("train finer.run/config.yaml -o again.run --quiet", 0);
    EXPECT_EQ(content("again.run/checkpoint.safetensors"),
              content("finer.run/checkpoint.safetensors"));
}

// Killed, and gone on with by either command when the first run is gone: the same bits.
TEST_F(RefineCommand, GoesOnWithoutTheFirstRun) {
    expect_code("refine first.run -o whole.run --quiet", 0);
    // Once the log says so nothing is left that the next start would undo.
    shell(work_, mscomp_ +
                     "refine first.run -o a.run --quiet --set train.epochs=1000 & pid=$!\n"
                     "until grep -qs 'saved at epoch' a.run/log.txt; do sleep 0.01; done\n"
                     "kill -KILL $pid; wait $pid; true");
    expect_code("refine first.run -o b.run --quiet --set train.epochs=1", 0);
    fs::rename(work_ + "/first.run", work_ + "/moved.run");
    expect_code("refine first.run -o c.run --quiet", 4);
    expect_code("refine first.run -o b.run --quiet --resume --set train.epochs=4", 0);
    EXPECT_EQ(content("b.run/checkpoint.safetensors"), content("whole.run/checkpoint.safetensors"));
    expect_code("train a.run/config.yaml -o a.run --quiet --resume --set train.epochs=4", 0);
    EXPECT_EQ(content("a.run/checkpoint.safetensors"), content("whole.run/checkpoint.safetensors"));
    // Another run is another beginning.
    EXPECT_THAT(expect_code("refine moved.run -o b.run --quiet --resume", 2).err,
                HasSubstr("was trained with another configuration"));
}

TEST_F(RefineCommand, RefusesWhatItCannotDo) {
    expect_code("train pca.yaml -o pca.run --quiet", 0);
    const std::string before = content("first.run/checkpoint.safetensors");
    const auto refused = [&](const std::string& arguments, int code, const std::string& why) {
        EXPECT_THAT(expect_code(arguments, code).err, HasSubstr(why));
    };
    refused("refine pca.run -o x.run", 2, "is of kind pca, whose components are changes of");
    refused("refine first.run -o first.run --force", 2,
            "first.run/checkpoint.safetensors is the input ");
    refused("refine first.run -o x.run --set model.tied=none", 2, "a key of the kind");
    refused(
        "refine first.run -o x.run --set 'model.levels=[{components: 2, sparsity_range: 1, "
        "max_support: 1}]'",
        2, "train.start: levels of 3 components");
    refused("refine nowhere -o x.run", 4, "nowhere");
    refused("refine autoencoder.yaml -o x.run", 6, "autoencoder.yaml");
    EXPECT_FALSE(fs::exists(work_ + "/x.run"));
    EXPECT_EQ(content("first.run/checkpoint.safetensors"), before);
    expect_code("refine first.run -o finer.run --quiet --set train.epochs=1", 0);
    refused("refine first.run -o finer.run", 2, "--force");
}

}  // namespace
}  // namespace mscomp
