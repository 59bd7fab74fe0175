// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "cli/spawned.h"

namespace mscomp {

/// What the programs made of a small twist, once for all tests of a program: meshes/ (3 shapes),
/// f.safetensors, c.yaml and sweep.yaml that train on it, and run/ that did.
class SmallRun {
  public:
    static const std::string& folder() {
        static const SmallRun all;
        return all.folder_.path();
    }

    static std::string program(const std::string& name) {
        return std::string(MSCOMP_BIN_DIR) + "/" + name;
    }

  private:
    SmallRun() {
        folder_.put("c.yaml",
                    "model: {kind: autoencoder, components: 2, sparsity_range: 0.3}\n"
                    "data: {features: f.safetensors, split: {train: every, step: 2}}\n"
                    "train: {epochs: 2, batch: 2}\n");
        folder_.put("sweep.yaml", "config: c.yaml\npoints: {grid: {model.components: [1, 2]}}\n");
        folder_.put("handles.json", R"({"handles": [{"vertex": 9, "position": [0, 0, 0]}]})");
        make({"acapfeat", "generate", "twist", "-o", "meshes", "--frames", "3", "--vertices", "100",
              "--turns", "0.3"});
        make({"acapfeat", "extract", "meshes", "-o", "f.safetensors"});
        make({"mscomp", "train", "c.yaml", "-o", "run"});
    }

    void make(std::vector<std::string> words) const {
        words[0] = program(words[0]);
        const Stream out = Stream::of_file(folder_ / "said.txt");
        const Start start{
            .words = words, .folder = folder_.path(), .out = out.number(), .err = out.number()};
        EXPECT_EQ(exit_code_of(start), 0)
            << words[1] << TemporaryFolder::content(folder_ / "said.txt");
    }

    TemporaryFolder folder_;
};

/// Every command at work, in a folder that is a copy of SmallRun's; results go to new names.
struct Command {
    std::vector<std::string> words;
    std::string output;  // the file or folder it makes; empty: text only
};

inline const std::vector<Command>& working_commands() {
    static const std::vector<Command> all{
        {{"acapfeat", "check", "meshes"}, ""},
        {{"acapfeat", "extract", "meshes", "-o", "g.safetensors"}, "g.safetensors"},
        {{"acapfeat", "info", "f.safetensors"}, ""},
        {{"acapfeat", "info", "f.safetensors", "--json"}, ""},
        {{"acapfeat", "reconstruct", "f.safetensors", "-o", "again"}, "again/frame_0002.obj"},
        {{"acapfeat", "convert", "f.safetensors", "g.npz"}, "g.npz"},
        {{"acapfeat", "convert", "f.safetensors", "g.npy"}, "g.npy"},
        {{"acapfeat", "generate", "arm", "-o", "arm", "--frames", "2", "--vertices", "100"},
         "arm/truth.json"},
        {{"mscomp", "init", "autoencoder"}, ""},
        {{"mscomp", "train", "c.yaml", "-o", "again.run"}, "again.run/checkpoint.safetensors"},
        {{"mscomp", "refine", "run", "-o", "finer.run", "--set", "train.epochs=1"},
         "finer.run/checkpoint.safetensors"},
        {{"mscomp", "info", "run"}, ""},
        {{"mscomp", "export-components", "run", "-o", "parts"}, "parts/components.json"},
        {{"mscomp", "reconstruct", "run", "f.safetensors", "-o", "decoded"},
         "decoded/frame_0002.obj"},
        {{"mscomp", "evaluate", "run", "-o", "measures"}, "measures/table.csv"},
        {{"mscomp", "sweep", "sweep.yaml", "-o", "sweep"}, "sweep/table.csv"},
        {{"mscomp", "synthesize", "run", "--list"}, ""},
        {{"mscomp", "sample", "run", "-n", "2", "-o", "samples"}, "samples/codes.csv"}};
    return all;
}

/// A copy of SmallRun's folder, to be spoiled.
class CopiedRun : public testing::Test {
  protected:
    CopiedRun() {
        std::filesystem::copy(SmallRun::folder(), folder_.path(),
                              std::filesystem::copy_options::recursive);
    }

    Start start_of(std::vector<std::string> words) const {
        words[0] = SmallRun::program(words[0]);
        return {.words = std::move(words), .folder = folder_.path()};
    }

    struct Outcome {
        int code = -1;
        std::string out, err;
    };
    /// Runs it with its output and error caught.
    Outcome run(const std::vector<std::string>& words) const { return run(start_of(words)); }
    Outcome run(Start start) const {
        std::filesystem::remove(captured_ / "out");
        std::filesystem::remove(captured_ / "err");
        const Stream out = Stream::of_file(captured_ / "out"),
                     err = Stream::of_file(captured_ / "err");
        start.out = out.number();
        start.err = err.number();
        const int code = exit_code_of(start);
        return {code, TemporaryFolder::content(captured_ / "out"),
                TemporaryFolder::content(captured_ / "err")};
    }

    TemporaryFolder folder_;
    TemporaryFolder captured_;
};

inline std::string text_of(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
    return text;
}

}  // namespace mscomp
