// SPDX-License-Identifier: MIT
// Paths, limits and starts that go wrong: every command says so and ends with the code of it, never
// as a bug (1), by a signal or not at all.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/auxv.h>
#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <string>

#include "cli/small_run.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class BadSurroundings : public CopiedRun {
  protected:
    void expect_refusal(const std::vector<std::string>& words) const {
        Start start = start_of(words);
        start.most_seconds = 30;
        const Outcome outcome = run(start);
        EXPECT_TRUE(2 <= outcome.code && outcome.code <= 6)
            << outcome.code << ": " << text_of(words).substr(0, 300) << "\n"
            << outcome.err.substr(0, 300);
        EXPECT_THAT(outcome.err, HasSubstr(": error: ")) << text_of(words).substr(0, 300);
    }
};

/// Every way in which a command can be given a path.
std::vector<std::vector<std::string>> commands_with(const std::string& path) {
    return {{"acapfeat", "check", path},
            {"acapfeat", "check", "meshes/frame_0000.obj", "--reference", path},
            {"acapfeat", "extract", path, "-o", "x"},
            {"acapfeat", "extract", "--list", path, "-o", "x"},
            {"acapfeat", "extract", "meshes", "-o", path},
            {"acapfeat", "extract", "meshes", "-o", path, "--force"},
            {"acapfeat", "info", path},
            {"acapfeat", "reconstruct", path, "-o", "d"},
            {"acapfeat", "reconstruct", "f.safetensors", "-o", path, "--force"},
            {"acapfeat", "reconstruct", "f.safetensors", "-o", "d", "--handles", path},
            {"acapfeat", "convert", path, "x.npz"},
            {"acapfeat", "convert", "f.safetensors", path, "--to", "obj", "--force"},
            {"acapfeat", "convert", "f.safetensors", path, "--to", "npz", "--force"},
            {"acapfeat", "convert", "g.npz", "x.safetensors", "--reference", path},
            {"acapfeat", "generate", "arm", "-o", path, "--force"},
            {"mscomp", "train", path},
            {"mscomp", "train", "c.yaml", "-o", path, "--force"},
            {"mscomp", "train", "c.yaml", "-o", path, "--resume"},
            {"mscomp", "train", "c.yaml", "-o", "r", "--set", "data.features=" + path},
            {"mscomp", "train", "c.yaml", "-o", "r", "--set",
             "data.split={train: file, path: '" + path + "'}"},
            {"mscomp", "refine", path, "-o", "r"},
            {"mscomp", "refine", "run", "-o", path, "--force"},
            {"mscomp", "units", path, "-o", "u"},
            {"mscomp", "units", "f.safetensors", "-o", path, "--force"},
            {"mscomp", "info", path},
            {"mscomp", "export-components", path, "-o", "d"},
            {"mscomp", "export-components", "run", "-o", path, "--force"},
            {"mscomp", "reconstruct", path, "f.safetensors", "-o", "d"},
            {"mscomp", "reconstruct", "run", path, "-o", "d"},
            {"mscomp", "reconstruct", "run", "f.safetensors", "-o", path, "--force"},
            {"mscomp", "evaluate", path},
            {"mscomp", "evaluate", "run", path},
            {"mscomp", "evaluate", "run", "--units", path},
            {"mscomp", "evaluate", "run", "--truth", path},
            {"mscomp", "evaluate", "run", "-o", path, "--force"},
            {"mscomp", "sweep", path, "-o", "s"},
            {"mscomp", "sweep", "sweep.yaml", "-o", path, "--force"},
            {"mscomp", "synthesize", path, "--list"},
            {"mscomp", "synthesize", "run", "--weight", "1=1", "-o", path, "--force"},
            {"mscomp", "synthesize", "run", "--strongest", "1", "--sheet", path, "--force"},
            {"mscomp", "sample", path, "-n", "1", "-o", "d"},
            {"mscomp", "sample", "run", "-n", "1", "-o", path, "--force"}};
}

TEST_F(BadSurroundings, PathsThatLeadNowhereAreRefused) {
    fs::create_symlink("circle", folder_ / "circle");
    const std::string long_name(300, 'n'), long_path = std::string(5000, '/') + "x";
    for (const std::string& path :
         {std::string("circle"), std::string("circle/x.obj"), long_name,
          "run/" + long_name + "/x.obj", long_path, std::string("c.yaml/x.obj"),
          std::string("/proc/self/mem"), std::string("/proc/none/x.obj")}) {
        for (const std::vector<std::string>& words : commands_with(path)) expect_refusal(words);
    }
}

// /dev/zero never ends, a file under /proc says it has no bytes, a socket cannot be opened.
TEST_F(BadSurroundings, FilesThatAreNoneAreRefused) {
    for (const std::string path : {"/dev/null", "/proc/self/status"}) {
        for (const std::vector<std::string>& words : commands_with(path)) expect_refusal(words);
    }
    expect_refusal({"mscomp", "train", "/dev/zero"});
    expect_refusal({"acapfeat", "extract", "--list", "/dev/zero", "-o", "x"});
}

TEST_F(BadSurroundings, NumbersThatNoComputerHoldsAreRefused) {
    for (const char* key : {"train.batch", "train.epochs", "train.fill_up_to", "train.decay_steps",
                            "train.seed", "train.checkpoint_every", "train.plateau_epochs",
                            "model.components", "data.split.step", "data.split.count"}) {
        for (const char* value :
             {"99999999999999999999", "-1", "1e9", "0x10", "1e400", "nan", ""}) {
            expect_refusal(
                {"mscomp", "train", "c.yaml", "-o", "r", "--set", std::string(key) + "=" + value});
        }
    }
    for (const char* key : {"train.batch", "train.fill_up_to", "model.components", "train.epochs",
                            "train.decay_steps"}) {
        expect_refusal(
            {"mscomp", "train", "c.yaml", "-o", "r", "--set", std::string(key) + "=2147483647"});
    }
    for (const char* name : {"arm", "cloth", "face", "twist"}) {
        for (const char* option : {"--vertices", "--frames"}) {
            for (const char* value :
                 {"2147483647", "2147483640", "99999999999", "-5", "0", "1e9"}) {
                expect_refusal({"acapfeat", "generate", name, "-o", "g", option, value});
            }
        }
        expect_refusal({"acapfeat", "generate", name, "-o", "g", "--vertices", "20000000",
                        "--frames", "100000"});
    }
    for (const char* option : {"--turns", "--tilt", "--noise", "--thickness"}) {
        for (const char* value : {"1e308", "-1e308", "nan", "inf"}) {
            expect_refusal({"acapfeat", "generate", "twist", "-o", "g", option, value});
        }
    }
    expect_refusal({"mscomp", "sample", "run", "-n", "2147483648", "-o", "d"});
    expect_refusal({"mscomp", "evaluate", "run", "--handles", "2147483647"});
    expect_refusal(
        {"mscomp", "reconstruct", "run", "f.safetensors", "-o", "d", "--levels", "2147483647"});
}

// Deep text, text that stands for very much, and text that is in itself.
TEST_F(BadSurroundings, TextThatIsTooDeepOrTooMuchIsRefused) {
    const std::string deep(100'000, '['), deep_map = std::string(100'000, '{');
    std::string bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n";
    for (char c = 'b'; c < 'k'; ++c) {
        bomb += std::string(1, c) + ": &" + c + " [";
        for (int k = 0; k < 9; ++k)
            bomb += std::string(k > 0 ? ", *" : "*") + static_cast<char>(c - 1);
        bomb += "]\n";
    }
    const std::vector<std::string> hostile{
        deep,
        deep_map,
        "&a [*a]",
        "&a {b: *a}",
        bomb,
        "points: {grid: {train.seed: [&a [*a]]}}\nconfig: c.yaml\n",
        "points: {grid: {train.seed: &a [*a]}}\nconfig: c.yaml\n",
        bomb + "points: {grid: {x: [*j]}}\nconfig: c.yaml\n",
        std::string(3'000'000, 'x')};
    for (const std::string& text : hostile) {
        folder_.put("bad.yaml", text);
        expect_refusal({"mscomp", "train", "bad.yaml"});
        expect_refusal({"mscomp", "sweep", "bad.yaml", "-o", "s"});
        if (text.size() < 200)
            expect_refusal({"mscomp", "train", "c.yaml", "--set", "model=" + text});
    }
    std::string closed = deep + std::string(100'000, ']');
    for (const std::string& text :
         {deep, closed, R"({"handles": )" + closed + "}",
          R"({"handles": [{"vertex": )" + closed + "}]}", std::string("{\"handles\": [\0]}", 15),
          std::string(R"({"handles": [{"vertex": 1, "vertex": 2}]})")}) {
        folder_.put("bad.json", text);
        expect_refusal(
            {"acapfeat", "reconstruct", "f.safetensors", "-o", "d", "--handles", "bad.json"});
    }
}

TEST_F(BadSurroundings, ASweepOfMorePointsThanAnybodyTrainsIsRefused) {
    std::string grid;
    for (const char* key : {"train.epochs", "train.batch", "train.seed", "model.components"}) {
        grid += std::string(grid.empty() ? "" : ", ") + key + ": [1";
        for (int k = 2; k <= 100; ++k) grid += ", " + std::to_string(k);
        grid += "]";
    }
    folder_.put("many.yaml", "config: c.yaml\npoints: {grid: {" + grid + "}}\n");
    expect_refusal({"mscomp", "sweep", "many.yaml", "-o", "s"});
}

// A cache that is damaged is made anew; a record that is damaged is named with its line.
TEST_F(BadSurroundings, DamagedFilesOfASweepAreNoBug) {
    ASSERT_EQ(run({"mscomp", "sweep", "sweep.yaml", "-o", "s"}).code, 0);
    const std::string table = TemporaryFolder::content(folder_ / "s/table.csv");
    const std::string kept = "s/components=1/evaluation.json";
    ASSERT_TRUE(fs::exists(folder_ / kept));
    for (const std::string& text :
         {std::string(100'000, '['), std::string("{}"), std::string("\xff"),
          std::string(R"({"made_from": 1, "evaluation": {}})")}) {
        folder_.put(kept, text);
        EXPECT_EQ(run({"mscomp", "sweep", "sweep.yaml", "-o", "s"}).code, 0);
    }
    folder_.put("s/components=1/metrics.csv", "epoch,step,total,step_ms\n1,x,1,1\n");
    const Outcome outcome = run({"mscomp", "sweep", "sweep.yaml", "-o", "s"});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_THAT(outcome.err, HasSubstr("metrics.csv:2: got 'x', wanted a number"));
    folder_.put("s/components=1/metrics.csv",
                "epoch,step,total,step_ms\n1,9000000000000,1,1e305\n");
    const Outcome endless = run({"mscomp", "sweep", "sweep.yaml", "-o", "s"});
    EXPECT_EQ(endless.code, 3);
    EXPECT_THAT(endless.err, HasSubstr("metrics.csv:2: wanted epochs and steps that ascend"));
}

TEST_F(BadSurroundings, ADamagedRecordOfATrainingIsNamedWithItsLine) {
    std::string rows = TemporaryFolder::content(folder_ / "run/metrics.csv");
    rows.replace(rows.find("\n1,") + 1, 1, "x");
    folder_.put("run/metrics.csv", rows);
    const Outcome outcome = run(
        {"mscomp", "train", "run/config.yaml", "-o", "run", "--resume", "--set", "train.epochs=3"});
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("metrics.csv:2: got 'x', wanted a number"));
}

// Below some limit the loader cannot map the libraries, and says so with 127; from there on it is
// us.
TEST_F(BadSurroundings, LittleMemoryIsRefusedInTime) {
    for (rlim_t mebibytes = 50; mebibytes <= 400; mebibytes += 50) {
        for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
                 {"mscomp", "--version"},
                 {"acapfeat", "extract", "meshes", "-o", "x.safetensors"},
                 {"acapfeat", "reconstruct", "f.safetensors", "-o", "d"},
                 {"mscomp", "train", "c.yaml", "-o", "r"}}) {
            Start start = start_of(words);
            start.memory = mebibytes << 20U;
            start.most_seconds = 30;
            const Outcome outcome = run(start);
            EXPECT_TRUE(outcome.code == 0 || outcome.code == 4 || outcome.code == 5 ||
                        outcome.code == 127)
                << mebibytes << " MiB: " << outcome.code << ": " << text_of(words) << outcome.err;
            EXPECT_EQ(outcome.code != 0 && outcome.err.empty(), false) << text_of(words);
            for (const char* made : {"x.safetensors", "d", "r"}) fs::remove_all(folder_ / made);
        }
    }
}

/// Without the settings that tests run under, a program has some of its own to make.
class PlainEnvironment {
  public:
    PlainEnvironment() {
        if (const char* policy = std::getenv(kPolicy)) policy_ = policy;
        ::unsetenv(kPolicy);
    }
    PlainEnvironment(const PlainEnvironment&) = delete;
    PlainEnvironment& operator=(const PlainEnvironment&) = delete;
    ~PlainEnvironment() {
        if (policy_) ::setenv(kPolicy, policy_->c_str(), 1);
    }

  private:
    static constexpr const char* kPolicy = "OMP_WAIT_POLICY";
    std::optional<std::string> policy_;
};

// Run by the loader, the process is the loader's, and a new start would be that of the loader.
TEST_F(BadSurroundings, AProgramStartedByTheLoaderIsThatProgram) {
    const PlainEnvironment plain;
    Dl_info loader{};
    ASSERT_NE(::dladdr(reinterpret_cast<void*>(::getauxval(AT_BASE)), &loader), 0);
    for (const std::string& name : {std::string("acapfeat"), std::string("mscomp")}) {
        Start start = start_of({name, "--version"});
        start.words.insert(start.words.begin(), loader.dli_fname);
        const Outcome outcome = run(start);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_THAT(outcome.out, testing::StartsWith(name + " "));
    }
}

}  // namespace
}  // namespace mscomp
