// SPDX-License-Identifier: MIT
// No command writes over what it reads, by whatever name, nor gives a file the name of another
// kind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>

#include "cli/small_run.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class KeptInputs : public CopiedRun {
  protected:
    std::map<std::string, std::string> contents() const {
        std::map<std::string, std::string> all;
        for (const auto& entry : fs::recursive_directory_iterator(folder_.path())) {
            if (entry.is_regular_file()) {
                all[entry.path().string()] = TemporaryFolder::content(entry.path().string());
            }
        }
        return all;
    }
    void expect_kept(std::vector<std::string> words, const std::string& message) const {
        words.emplace_back("--force");
        const auto before = contents();
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.code, 2) << text_of(words) << "\n" << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << text_of(words);
        EXPECT_EQ(contents(), before) << text_of(words);
    }
};

TEST_F(KeptInputs, AreNoOutputsUnderTheirOwnNames) {
    const std::string message = "an input, wanted another output";
    fs::copy_file(folder_ / "meshes/frame_0000.obj", folder_ / "shape");
    folder_.put("list", "meshes/frame_0000.obj\nmeshes/frame_0001.obj\n");
    folder_.put("own.run/config.yaml", TemporaryFolder::content(folder_ / "c.yaml"));
    fs::copy_file(folder_ / "f.safetensors", folder_ / "own.run/f.safetensors");
    fs::copy_file(folder_ / "run/checkpoint.safetensors", folder_ / "model.ply");
    fs::create_directory(folder_ / "parts");
    fs::copy_file(folder_ / "model.ply", folder_ / "parts/model.ply");
    fs::copy_file(folder_ / "model.ply", folder_ / "parts/model.obj");
    fs::copy_file(folder_ / "model.ply", folder_ / "parts/model.png");
    fs::copy_file(folder_ / "f.safetensors", folder_ / "parts/f.obj");
    folder_.put("parts/units.csv", "a\n1\n0\n1\n");
    folder_.put("out/sweep.yaml", TemporaryFolder::content(folder_ / "sweep.yaml"));
    folder_.put("out/c.yaml", TemporaryFolder::content(folder_ / "c.yaml"));
    folder_.put("out/f.safetensors", TemporaryFolder::content(folder_ / "f.safetensors"));
    expect_kept({"acapfeat", "extract", "--list", "list", "-o", "list"}, message);
    expect_kept({"acapfeat", "reconstruct", "parts/f.obj", "-o", "parts"}, message);
    expect_kept({"acapfeat", "convert", "f.safetensors", "f.safetensors"}, message);
    expect_kept({"acapfeat", "convert", "meshes", "meshes", "--to", "obj"}, message);
    expect_kept({"acapfeat", "convert", "meshes/frame_0000.obj", "meshes/frame_0000.obj"}, message);
    expect_kept({"mscomp", "train", "own.run/config.yaml", "-o", "own.run"}, message);
    expect_kept({"mscomp", "export-components", "parts/model.ply", "-o", "parts"}, message);
    expect_kept({"mscomp", "reconstruct", "parts/model.obj", "f.safetensors", "-o", "parts"},
                message);
    expect_kept({"mscomp", "evaluate", "parts/model.png", "-o", "parts"}, message);
    expect_kept({"mscomp", "evaluate", "run", "--units", "parts/units.csv", "-o", "parts"},
                message);
    expect_kept({"mscomp", "evaluate", "run", "--truth", "parts/units.csv", "-o", "parts"},
                message);
    expect_kept({"mscomp", "sample", "parts/model.obj", "-n", "1", "-o", "parts"}, message);
    expect_kept({"mscomp", "synthesize", "model.ply", "--weight", "1=1", "-o", "model.ply"},
                message);
    expect_kept({"mscomp", "synthesize", "parts/model.png", "--strongest", "1", "--sheet",
                 "parts/model.png"},
                message);
    expect_kept({"mscomp", "sweep", "out/sweep.yaml", "-o", "out"}, message);
}

TEST_F(KeptInputs, AreNoOutputsThroughLinks) {
    fs::create_symlink("f.safetensors", folder_ / "link.safetensors");
    fs::create_hard_link(folder_ / "f.safetensors", folder_ / "hard.safetensors");
    fs::create_directory_symlink(".", folder_ / "here");
    for (const char* name : {"link.safetensors", "hard.safetensors", "here/f.safetensors",
                             "./meshes/../f.safetensors"}) {
        expect_kept({"acapfeat", "convert", "f.safetensors", name}, "is the input f.safetensors");
    }
    fs::create_directory(folder_ / "out");
    fs::create_symlink("../meshes/frame_0001.obj", folder_ / "out/frame_0001.obj");
    expect_kept({"acapfeat", "convert", "meshes", "out", "--to", "obj"},
                "is the input meshes/frame_0001.obj");
}

TEST_F(KeptInputs, NamesOfAnotherKindAreRefused) {
    const auto refused = [&](const std::vector<std::string>& words, const std::string& message) {
        expect_kept(words, message);
    };
    for (const char* name : {"x.obj", "x.PLY", "x.off", "x.npz", "x.npy", "x.h5", "x.json"}) {
        refused({"acapfeat", "extract", "meshes", "-o", name},
                "would be a feature file, wanted a name that ends in .safetensors");
    }
    refused({"acapfeat", "extract", "meshes", "-o", "meshes/frame_0000.obj"}, "a feature file");
    refused({"acapfeat", "convert", "f.safetensors", "x.obj", "--to", "npz"}, "ends in .npz");
    refused({"acapfeat", "convert", "meshes", "x.safetensors", "--to", "ply"},
            "would be a folder, wanted a name that does not end in .safetensors");
    refused({"acapfeat", "reconstruct", "f.safetensors", "-o", "x.obj"}, "would be a folder");
    refused({"acapfeat", "generate", "arm", "-o", "x.obj"}, "would be a folder");
    refused({"mscomp", "train", "c.yaml", "-o", "model.safetensors"}, "would be a run folder");
    refused({"mscomp", "synthesize", "run", "--weight", "1=1", "-o", "x.png"}, "would be a mesh");
    refused({"mscomp", "synthesize", "run", "--strongest", "1", "--sheet", "x.obj"},
            "would be a picture");
    refused({"mscomp", "sample", "run", "-n", "1", "-o", "x.ply"}, "would be a folder");
    refused({"mscomp", "evaluate", "run", "-o", "x.csv"}, "would be a folder");
    refused({"mscomp", "sweep", "sweep.yaml", "-o", "x.csv"}, "would be a folder");
}

// A run goes on with the configuration that lies in it.
TEST_F(KeptInputs, ARunMayGoOnWithItsOwnConfiguration) {
    EXPECT_EQ(run({"mscomp", "train", "run/config.yaml", "-o", "run", "--resume", "--set",
                   "train.epochs=3"})
                  .code,
              0);
}

TEST_F(KeptInputs, AFileThatIsReplacedKeepsItsModeAndItsOwner) {
    const std::string file = folder_ / "g.safetensors";
    for (const mode_t mode : {0600U, 0640U, 0444U, 0755U}) {
        folder_.put("g.safetensors", "earlier");
        ASSERT_EQ(::chmod(file.c_str(), mode), 0);
        const bool is_root = ::geteuid() == 0;
        if (is_root) {
            ASSERT_EQ(::chown(file.c_str(), 12345, 23456), 0);
        }
        ASSERT_EQ(run({"acapfeat", "extract", "meshes", "-o", "g.safetensors", "--force"}).code, 0);
        struct stat info {};
        ASSERT_EQ(::stat(file.c_str(), &info), 0);
        EXPECT_EQ(info.st_mode & 07777U, mode);
        EXPECT_TRUE(!is_root || (info.st_uid == 12345 && info.st_gid == 23456));
    }
}

TEST_F(KeptInputs, AnOutputThatIsALinkStaysOne) {
    folder_.put("elsewhere/g.safetensors", "earlier");
    fs::create_symlink("elsewhere/g.safetensors", folder_ / "g.safetensors");
    ASSERT_EQ(run({"acapfeat", "extract", "meshes", "-o", "g.safetensors", "--force"}).code, 0);
    EXPECT_TRUE(fs::is_symlink(folder_ / "g.safetensors"));
    EXPECT_EQ(TemporaryFolder::content(folder_ / "elsewhere/g.safetensors"),
              TemporaryFolder::content(folder_ / "f.safetensors"));
    fs::create_symlink("nowhere", folder_ / "h.safetensors");
    const Outcome outcome =
        run({"acapfeat", "extract", "meshes", "-o", "h.safetensors", "--force"});
    EXPECT_EQ(outcome.code, 4);
    EXPECT_THAT(outcome.err, HasSubstr("is a link to nowhere"));
}

}  // namespace
}  // namespace mscomp
