// SPDX-License-Identifier: MIT
// Names and values that would steer a terminal come out of every command as harmless text.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/small_run.h"
#include "mscomp/base/printable.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;

/// What would clear, colour or rename the terminal, begin a line of its own, or turn around what is
/// beside it: as C0, as line breaks, as C1 and separators in UTF-8, as bytes that are none.
const std::vector<std::string> kHostile{"\x1b[2Jx\x1b]0;owned\x07\x7f\x08",
                                        "a\rb\nacapfeat: error: b",
                                        "\xc2\x9b"
                                        "31m\xe2\x80\xae\xe2\x81\xa6\xe2\x80\xa8x",
                                        "\xff\xfe\x9b\xc0\x9b\xed\xa0\x80x"};

bool is_harmless(const std::string& text) { return printable_lines(text) == text; }

class UntrustedText : public CopiedRun {
  protected:
    /// Runs it and looks at all that it says; the number of lines shows that none was begun.
    Outcome expect_harmless(const std::vector<std::string>& words) const {
        Outcome outcome = run(words);
        EXPECT_NE(outcome.code, 1) << printable(text_of(words)) << printable(outcome.err);
        EXPECT_LT(outcome.code, 128) << printable(text_of(words));
        EXPECT_TRUE(is_harmless(outcome.out))
            << printable(text_of(words)) << printable(outcome.out);
        EXPECT_TRUE(is_harmless(outcome.err))
            << printable(text_of(words)) << printable(outcome.err);
        EXPECT_EQ(outcome.err.find("\nacapfeat: error: b"), std::string::npos) << outcome.err;
        return outcome;
    }
};

TEST_F(UntrustedText, OfOptionsAndNamesIsShownHarmless) {
    for (const std::string& text : kHostile) {
        for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
                 {"acapfeat", text},
                 {"acapfeat", "--" + text},
                 {"acapfeat", "info", "--" + text},
                 {"acapfeat", "info", text},
                 {"acapfeat", "check", text},
                 {"acapfeat", "check", "meshes", "--reference", text},
                 {"acapfeat", "extract", text + "*", "-o", "x"},
                 {"acapfeat", "extract", "--list", text, "-o", "x"},
                 {"acapfeat", "extract", "meshes", "-o", "x", "--weights", text},
                 {"acapfeat", "extract", "meshes", "-o", "none/" + text + "/\x1bx", "--quiet"},
                 {"acapfeat", "reconstruct", "f.safetensors", "-o", text + "d", "--frames", text},
                 {"acapfeat", "reconstruct", "f.safetensors", "-o", "d", "--handles", text},
                 {"acapfeat", "generate", text, "-o", "x"},
                 {"acapfeat", "generate", "arm", "-o", "y", "--seed", text},
                 {"acapfeat", "generate", "arm", "-o", "y", "--vertices", text},
                 {"acapfeat", "convert", text, "x.npz"},
                 {"acapfeat", "convert", "f.safetensors", text},
                 {"acapfeat", "info", "f.safetensors", "--threads", text},
                 {"mscomp", "init", text},
                 {"mscomp", "train", text},
                 {"mscomp", "train", "c.yaml", "-o", "r", "--set", text},
                 {"mscomp", "train", "c.yaml", "-o", "r", "--set", "data.features=" + text},
                 {"mscomp", "train", "c.yaml", "-o", "r", "--set", "model.kind=" + text},
                 {"mscomp", "train", "c.yaml", "-o", "r", "--set", text + "=1"},
                 {"mscomp", "info", text},
                 {"mscomp", "evaluate", "run", text},
                 {"mscomp", "evaluate", "run", "--units", text},
                 {"mscomp", "evaluate", "run", "--truth", text},
                 {"mscomp", "synthesize", "run", "--weight", text + "=1", "-o", "x.obj"},
                 {"mscomp", "synthesize", "run", "--sheet", "x.png", "--component", text},
                 {"mscomp", "sweep", text, "-o", "s"},
                 {"mscomp", "sample", "run", "-n", text, "-o", "s"}}) {
            // A word cannot hold a zero byte, and an empty option is none.
            expect_harmless(words);
        }
    }
}

TEST_F(UntrustedText, InFilesIsShownHarmless) {
    for (const std::string& text : kHostile) {
        const std::string obj = TemporaryFolder::content(folder_ / "meshes/frame_0001.obj");
        folder_.put("bad.obj", obj + text + "\n");
        folder_.put("list.txt", text + "\n");
        folder_.put("bad.yaml", "\"" + text + "\": 1\n");
        folder_.put("value.yaml", "model: {kind: \"" + text + "\"}\n");
        folder_.put("plain.yaml", text + ": 1\n");
        folder_.put("points.yaml", "config: c.yaml\npoints: {list: [{name: '" + text + "'}]}\n");
        folder_.put("title.yaml", "base: {" + text + ": 1}\npoints: {grid: {a: [1]}}\n");
        folder_.put("handles.json", "{\"" + text + "\": 1}");
        folder_.put("truth.json", "{\"names\": [\"" + text + "\", \"" + text + "\"]}");
        folder_.put("units.csv", text + ",b\n1,x" + text + "\n");
        folder_.put("bad.ply", "ply\nformat ascii 1.0\nelement " + text + " 3\nend_header\n");
        for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
                 {"acapfeat", "check", "bad.obj"},
                 {"acapfeat", "check", "bad.obj", "--json"},
                 {"acapfeat", "extract", "bad.obj", "-o", "x"},
                 {"acapfeat", "extract", "bad.ply", "-o", "x"},
                 {"acapfeat", "extract", "--list", "list.txt", "-o", "x"},
                 {"acapfeat", "reconstruct", "f.safetensors", "-o", "d", "--handles",
                  "handles.json"},
                 {"mscomp", "train", "bad.yaml"},
                 {"mscomp", "train", "value.yaml"},
                 {"mscomp", "train", "plain.yaml"},
                 {"mscomp", "sweep", "points.yaml", "-o", "s"},
                 {"mscomp", "sweep", "title.yaml", "-o", "s"},
                 {"mscomp", "evaluate", "run", "--truth", "truth.json"},
                 {"mscomp", "evaluate", "run", "--units", "units.csv"}}) {
            expect_harmless(words);
        }
    }
}

/// A feature file, and with it a run, whose shapes are called so.
TEST_F(UntrustedText, OfShapesIsHarmlessWhereverItGoes) {
    for (std::size_t k = 0; k < kHostile.size(); ++k) {
        const std::string name = kHostile[k];
        const std::string folder = "set" + std::to_string(k), number = std::to_string(k);
        fs::create_directory(folder_ / folder);
        for (const char* frame : {"0", "1", "2"}) {
            fs::copy_file(folder_ / ("meshes/frame_000" + std::string(frame) + ".obj"),
                          folder_ / (folder + "/" + name + frame + ".obj"));
        }
        const std::string features = number + ".safetensors", run_name = number + ".run";
        EXPECT_EQ(expect_harmless({"acapfeat", "check", folder}).code, 0);
        EXPECT_EQ(expect_harmless({"acapfeat", "extract", folder, "-o", features}).code, 0);
        EXPECT_EQ(expect_harmless({"acapfeat", "info", features}).code, 0);
        EXPECT_EQ(expect_harmless({"acapfeat", "reconstruct", features, "-o", "d" + number}).code,
                  0);
        EXPECT_EQ(expect_harmless({"mscomp", "train", "c.yaml", "-o", run_name, "--set",
                                   "data.features=" + features})
                      .code,
                  0);
        EXPECT_TRUE(is_harmless(TemporaryFolder::content(folder_ / (run_name + "/log.txt"))));
        EXPECT_EQ(expect_harmless({"mscomp", "info", run_name}).code, 0);
        EXPECT_EQ(expect_harmless({"mscomp", "evaluate", run_name, "-o", "m" + number}).code, 0);
        const Outcome json = expect_harmless({"mscomp", "evaluate", run_name, "--json"});
        EXPECT_TRUE(nlohmann::json::accept(json.out)) << json.out;
    }
}

// What a JSON string escapes is still the name.
TEST_F(UntrustedText, InJsonIsEscapedAndWhole) {
    const std::string name = "a\x1b[1m\xc2\x9b\xe2\x80\xae.obj";
    fs::copy_file(folder_ / "meshes/frame_0000.obj", folder_ / name);
    const Outcome outcome = expect_harmless({"acapfeat", "check", name, "--json"});
    EXPECT_EQ(nlohmann::json::parse(outcome.out).at("reference"), name);
}

// The features of a run may be called as they like, too.
TEST_F(UntrustedText, OfAFeatureFileReachesNeitherLogNorTerminal) {
    const std::string name = "\x1b[2J\xff\xc2\x9b.safetensors";
    fs::copy_file(folder_ / "f.safetensors", folder_ / name);
    const std::vector<std::string> train{
        "mscomp", "train", "c.yaml", "-o", "r", "--set", "data.features=" + name};
    EXPECT_EQ(expect_harmless(train).code, 0);
    EXPECT_TRUE(is_harmless(TemporaryFolder::content(folder_ / "r/log.txt")));
    EXPECT_EQ(expect_harmless({"mscomp", "info", "r"}).code, 0);
    EXPECT_EQ(expect_harmless({"mscomp", "evaluate", "r", name}).code, 0);
    std::vector<std::string> again = train;
    again.emplace_back("--resume");
    EXPECT_EQ(expect_harmless(again).code, 0);
}

}  // namespace
}  // namespace mscomp
