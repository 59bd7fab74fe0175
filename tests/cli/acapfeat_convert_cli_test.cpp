// SPDX-License-Identifier: MIT
// `acapfeat convert`, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/convert/splocs_file.h"
#include "shapes.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct Outcome {
    int code = -1;
    std::string out, err;
};

class Convert : public testing::Test {
  protected:
    Convert() {
        fs::create_directories(folder_ + "/work");
        TriangleMesh mesh = shapes::icosphere(1);
        for (int i = 0; i < 3; ++i) {
            for (Point& p : mesh.vertices) p = {p[1] + i, p[2] * (1 + 0.1 * i), p[0]};
            write_obj(path("in/frame_" + std::to_string(5 * i) + ".obj"), mesh);
        }
    }

    std::string path(const std::string& name) const { return folder_ + "/work/" + name; }

    // Runs in the work folder; quoting is the caller's.
    Outcome run_any(const std::string& command) const {
        const std::string line = "cd '" + folder_ + "/work' && " + command + " >'" + folder_ +
                                 "/out' 2>'" + folder_ + "/err'";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(folder_ + "/out"), read_file(folder_ + "/err")};
    }
    Outcome run(const std::string& arguments) const {
        return run_any(std::string(MSCOMP_BIN_DIR) + "/acapfeat " + arguments);
    }
    // What succeeds says on standard error.
    std::string convert(const std::string& arguments) const {
        const Outcome outcome = run("convert " + arguments);
        EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
        return outcome.err;
    }
    // A failing command leaves the folder as it was.
    std::string refusal(const std::string& arguments, int code) const {
        const auto before = files("");
        const Outcome outcome = run("convert " + arguments);
        EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr("acapfeat: error: ")) << arguments;
        EXPECT_EQ(outcome.out, "") << arguments;
        EXPECT_TRUE(files("") == before) << arguments;
        return outcome.err;
    }

    /// Content of every file in a folder of the work folder.
    std::map<std::string, std::string> files(const std::string& folder) const {
        std::map<std::string, std::string> contents;
        for (const auto& entry : fs::recursive_directory_iterator(path(folder))) {
            if (!entry.is_regular_file()) continue;
            contents[fs::relative(entry.path(), path(folder)).string()] =
                TemporaryFolder::content(entry.path().string());
        }
        return contents;
    }
    FeatureSet extracted() const {
        EXPECT_EQ(run("extract in -o f.safetensors --quiet").code, 0);
        return read_features(path("f.safetensors"));
    }

    TemporaryFolder temporary_;
    std::string folder_ = temporary_.path();
};

TEST_F(Convert, HelpEndsWithAnExample) {
    EXPECT_THAT(run("convert --help").out, HasSubstr("\nExample:\n  acapfeat convert"));
}

// Nine digits of a position survive in the 64 bits of the arrays.
TEST_F(Convert, MeshesComeBackFromAnNpzByteForByte) {
    EXPECT_THAT(convert("in s.npz"), Not(HasSubstr("note")));
    EXPECT_THAT(convert("s.npz back"), Not(HasSubstr("note")));
    EXPECT_EQ(files("back"), files("in"));
}

TEST_F(Convert, MeshesComeBackFromHdf5ByteForByte) {
    if (!has_hdf5()) {
        EXPECT_THAT(refusal("in s.h5", 2), HasSubstr("no HDF5"));
        return;
    }
    EXPECT_THAT(convert("in s.h5"), HasSubstr("note: s.h5 does not hold names"));
    EXPECT_THAT(convert("s.h5 back"), HasSubstr("names are shape_0000"));
    EXPECT_EQ(files("back").size(), 3U);
    EXPECT_EQ(files("back")["shape_0002.obj"], files("in")["frame_10.obj"]);
}

TEST_F(Convert, MeshesChangeTheirFormat) {
    const std::string note = convert("in ply --to ply");
    EXPECT_THAT(note, HasSubstr("does not hold digits beyond float32 of the positions"));
    EXPECT_THAT(convert("'in/*_5.obj' one.off"), Not(HasSubstr("note")));
    EXPECT_THAT(convert("one.off one.obj"), Not(HasSubstr("note")));
    EXPECT_EQ(read_file(path("one.obj")), files("in")["frame_5.obj"]);
    // float32 survives nine digits.
    convert("ply again --to obj");
    convert("again ply2 --to ply");
    EXPECT_EQ(files("ply2"), files("ply"));
    EXPECT_EQ(read_mesh(path("ply/frame_0.ply")).faces, read_mesh(path("in/frame_0.obj")).faces);
}

TEST_F(Convert, FeaturesComeBackFromAnNpzByteForByte) {
    extracted();
    EXPECT_THAT(convert("f.safetensors f.npz"), Not(HasSubstr("note")));
    EXPECT_THAT(convert("f.npz g.safetensors"), Not(HasSubstr("note")));
    EXPECT_EQ(read_file(path("g.safetensors")), read_file(path("f.safetensors")));
}

TEST_F(Convert, FeaturesComeBackFromTheAuthorsTextBitForBit) {
    const FeatureSet set = extracted();
    EXPECT_THAT(convert("f.safetensors LOGRNEW_a.txt"),
                AllOf(HasSubstr("does not hold"), HasSubstr("reference")));
    EXPECT_TRUE(fs::exists(path("S_a.txt")));
    EXPECT_THAT(refusal("LOGRNEW_a.txt g.safetensors", 2), HasSubstr("--reference MESH"));
    const std::string note =
        convert("LOGRNEW_a.txt g.safetensors --reference in/frame_0.obj --weights cotangent");
    EXPECT_THAT(note, AllOf(HasSubstr("faces are those of in/frame_0.obj"),
                            HasSubstr("vertices are made from the features")));
    const FeatureSet back = read_features(path("g.safetensors"));
    EXPECT_EQ(back.features, set.features);
    EXPECT_EQ(back.reference.vertices, set.reference.vertices);
    EXPECT_EQ(back.reference.faces, set.reference.faces);
    EXPECT_EQ(back.weights, "cotangent");
}

// Extraction moves every shape to the reference; converting moves it back, to float32 precision.
TEST_F(Convert, FeaturesGiveTheVerticesWhereTheInputStood) {
    const FeatureSet set = extracted();
    EXPECT_THAT(convert("f.safetensors back"), HasSubstr("back does not hold features"));
    convert("f.safetensors still --aligned");
    for (int i = 0; i < 3; ++i) {
        const std::string name = "/frame_" + std::to_string(5 * i) + ".obj";
        const TriangleMesh wanted = read_mesh(path("in" + name)),
                           back = read_mesh(path("back" + name)),
                           still = read_mesh(path("still" + name));
        double largest = 0;
        for (std::size_t v = 0; v < wanted.vertices.size(); ++v) {
            for (std::size_t k = 0; k < 3; ++k) {
                const double error = std::abs(back.vertices[v][k] - wanted.vertices[v][k]);
                if (!(error <= largest)) largest = error;
                const std::size_t at = static_cast<std::size_t>(i) * set.vertices.size() / 3;
                EXPECT_EQ(static_cast<float>(still.vertices[v][k]), set.vertices[at + 3 * v + k]);
            }
        }
        EXPECT_TRUE(largest <= 1e-6) << largest;
    }
    convert("f.safetensors v.npz --vertices --aligned");
    convert("v.npz still2");
    EXPECT_EQ(files("still2"), files("still"));
}

TEST_F(Convert, PlainArraysHoldFeaturesOrVertices) {
    const FeatureSet set = extracted();
    EXPECT_THAT(convert("f.safetensors f.npy"), HasSubstr("does not hold vertices"));
    convert("f.npy g.safetensors --reference in/frame_0.obj");
    EXPECT_EQ(read_features(path("g.safetensors")).features, set.features);
    EXPECT_THAT(convert("in v.npy"), HasSubstr("v.npy does not hold faces, names"));
    convert("v.npy back --reference in/frame_5.obj");
    EXPECT_EQ(files("back")["shape_0001.obj"], files("in")["frame_5.obj"]);
}

TEST_F(Convert, FeaturesOfMeshesAreTheWorkOfExtract) {
    EXPECT_THAT(refusal("in f.safetensors", 2), HasSubstr("acapfeat extract in -o"));
    EXPECT_THAT(refusal("in LOGRNEW.txt", 2), HasSubstr("acapfeat extract in -o"));
    convert("in s.npz");
    EXPECT_THAT(refusal("s.npz f.safetensors", 2),
                HasSubstr("acapfeat convert s.npz MESHES --to obj, then acapfeat extract MESHES"));
}

TEST_F(Convert, ExistingOutputStaysUnlessForced) {
    write_file(path("s.npz"), "precious");
    EXPECT_THAT(refusal("in s.npz", 2), HasSubstr("--force"));
    convert("in s.npz --force");
    EXPECT_NE(read_file(path("s.npz")), "precious");
    EXPECT_THAT(refusal("s.npz in", 2), HasSubstr("--force"));
    extracted();
    write_file(path("S.txt"), "precious");
    EXPECT_THAT(refusal("f.safetensors LOGRNEW.txt", 2), HasSubstr("S.txt exists"));
    convert("f.safetensors LOGRNEW.txt --force");
}

TEST_F(Convert, ACommandLineThatCannotBeMeantIsTwo) {
    EXPECT_THAT(refusal("in out.stl", 2), HasSubstr("cannot tell the format"));
    write_file(path("notes.doc"), "");
    EXPECT_THAT(refusal("notes.doc out", 2), HasSubstr("cannot tell the format"));
    EXPECT_THAT(refusal("nowhere out", 2), HasSubstr("there is no file or folder 'nowhere'"));
    EXPECT_THAT(refusal("in one.ply", 2), HasSubstr("holds 3 shapes, one.ply would hold one"));
    EXPECT_THAT(refusal("in s.npz --reference in/frame_0.obj", 2), HasSubstr("of its own"));
    refusal("in out --to stl", 2);
    refusal("in", 2);
    extracted();
    EXPECT_THAT(refusal("f.safetensors log.txt", 2), HasSubstr("begins with LOGRNEW"));
    EXPECT_THAT(refusal("S.txt g.safetensors", 2), HasSubstr("wanted the LOGRNEW*.txt"));
}

TEST_F(Convert, DamagedInputIsThree) {
    convert("in s.npz");
    const std::string whole = read_file(path("s.npz"));
    write_file(path("short.npz"), whole.substr(0, whole.size() / 2));
    EXPECT_THAT(refusal("short.npz back", 3), HasSubstr("short.npz: "));
    std::string altered = whole;
    altered[whole.size() / 2] = static_cast<char>(altered[whole.size() / 2] ^ 1);
    write_file(path("altered.npz"), altered);
    EXPECT_THAT(refusal("altered.npz back", 3), HasSubstr("checksum"));
    write_file(path("x.npy"), "nothing");
    EXPECT_THAT(refusal("x.npy back", 3), HasSubstr("not a numpy array"));
    write_file(path("LOGRNEW.txt"), "0 0 0 0 0 0 0 0\n");
    write_file(path("S.txt"), "1 0 0 0 1 0 0 0 1\n");
    EXPECT_THAT(refusal("LOGRNEW.txt g.safetensors --reference in/frame_0.obj", 3),
                HasSubstr("LOGRNEW.txt:1:16: "));
    write_file(path("LOGRNEW.txt"), "0 0 0 0 0 0 0 0 0\n");
    EXPECT_THAT(refusal("LOGRNEW.txt g.safetensors --reference in/frame_0.obj", 3),
                HasSubstr("in/frame_0.obj: 42 vertices, but LOGRNEW.txt has 1"));
}

TEST_F(Convert, MissingInputIsFour) {
    refusal("nowhere.npz out", 4);
    refusal("nowhere.npy out", 4);
    refusal("nowhere.safetensors out", 4);
    refusal("LOGRNEW.txt out", 4);
    if (has_hdf5()) refusal("nowhere.h5 out", 4);
}

TEST_F(Convert, TheSummaryCanBeJson) {
    const Outcome outcome = run("convert in v.npy --json --quiet");
    EXPECT_EQ(outcome.err, "");
    const auto summary = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(summary["shapes"], 3);
    EXPECT_EQ(summary["vertices"], 42);
    EXPECT_EQ(summary["features"], false);
    EXPECT_EQ(summary["lost"], nlohmann::json({"faces", "names"}));
}

// numpy is the judge of what an npz is, both ways.
TEST_F(Convert, NumpyReadsWhatIsWrittenAndIsRead) {
    if (run_any("/usr/bin/python3 -c 'import numpy'").code != 0) GTEST_SKIP() << "no numpy";
    const FeatureSet set = extracted();
    convert("f.safetensors f.npz");
    write_file(path("copy.py"),
               "import numpy as np\n"
               "f = np.load('f.npz')\n"
               "assert f['features'].shape == (3, 42, 9) and f['features'].dtype == np.float32\n"
               "assert f['reference'].shape == (42, 3) and f['reference'].dtype == np.float64\n"
               "assert f['faces'].dtype == np.int32 and f['faces'].max() == 41\n"
               "assert list(f['names']) == ['frame_0', 'frame_5', 'frame_10']\n"
               "assert str(f['weights']) == 'cotangent'\n"
               "arrays = {k: np.asfortranarray(f[k]) for k in f.files}\n"
               "arrays['faces'] = arrays['faces'].astype(np.int64)\n"
               "np.savez_compressed('g.npz', **arrays)\n");
    const Outcome copied = run_any("/usr/bin/python3 copy.py");
    ASSERT_EQ(copied.code, 0) << copied.err;
    EXPECT_THAT(convert("g.npz g.safetensors"), Not(HasSubstr("note")));
    EXPECT_EQ(read_file(path("g.safetensors")), read_file(path("f.safetensors")));
}

}  // namespace
}  // namespace mscomp
