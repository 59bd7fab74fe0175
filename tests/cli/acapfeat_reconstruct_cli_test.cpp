// SPDX-License-Identifier: MIT
// `acapfeat reconstruct`, run as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/temporary_folder.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/points.h"
#include "mscomp/base/safetensors.h"
#include "shapes.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Outcome {
    int code = -1;
    std::string out, err;
};

/// Three poses of a ball that is bent and moved away, and their features.
class Reconstruct : public testing::Test {
  protected:
    Reconstruct() {
        for (int i = 0; i < 3; ++i) {
            TriangleMesh mesh = shapes::icosphere(2);
            for (Point& p : mesh.vertices) {
                const double angle = 0.4 * i * p[2];
                p = {std::cos(angle) * p[0] - std::sin(angle) * p[1] + 0.2 * i * p[2] * p[2],
                     std::sin(angle) * p[0] + std::cos(angle) * p[1] + i, p[2]};
            }
            write_obj(path("in/pose_" + std::to_string(i) + ".obj"), mesh);
        }
        EXPECT_EQ(run("extract in -o f.safetensors").code, 0);
    }

    std::string path(const std::string& name) const { return folder_ + "/" + name; }
    Outcome run(const std::string& arguments) const {
        const std::string line = "cd '" + folder_ + "/' && " MSCOMP_BIN_DIR "/acapfeat " +
                                 arguments + " >out.txt 2>err.txt";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(path("out.txt")), read_file(path("err.txt"))};
    }
    /// The largest distance of a vertex from that of the input.
    double distance(const std::string& folder, int pose, const std::string& extension) const {
        const std::string name = "pose_" + std::to_string(pose);
        const TriangleMesh truth = read_mesh(path("in/" + name + ".obj"));
        const TriangleMesh mesh = read_mesh(path(folder + "/" + name + "." + extension));
        EXPECT_EQ(mesh.faces, truth.faces);
        double largest = 0;
        for (std::size_t i = 0; i < truth.vertices.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double d = std::abs(mesh.vertices[i][axis] - truth.vertices[i][axis]);
                if (!(d <= largest)) largest = d;
            }
        }
        return largest;
    }

    /// The poses, the i-th of them moved by `moves(i)`, in another folder.
    template <class Moves>
    void move_to(const std::string& folder, Moves&& moves) const {
        for (int i = 0; i < 3; ++i) {
            const std::string name = "/pose_" + std::to_string(i) + ".obj";
            TriangleMesh mesh = read_mesh(path("in" + name));
            const Point move = moves(i);
            for (Point& p : mesh.vertices) p = {p[0] + move[0], p[1] + move[1], p[2] + move[2]};
            write_obj(path(folder + name), mesh);
        }
    }
    struct Errors {
        double told = 0, written = 0;
    };
    /// Of a folder of poses, there and back: the error that is printed, and that of the files.
    Errors errors_in(const std::string& folder, const std::string& format) const {
        EXPECT_EQ(run("extract " + folder + " -o moved.safetensors --force").code, 0);
        const Outcome outcome = run("reconstruct moved.safetensors -o back_" + format +
                                    " --force --json --format " + format);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        double squares = 0;
        for (int i = 0; i < 3; ++i) {
            const std::string name = "/pose_" + std::to_string(i) + ".";
            const TriangleMesh truth = read_mesh(path(folder + name + "obj"));
            const TriangleMesh back = read_mesh(path("back_" + format + name + format));
            for (std::size_t v = 0; v < truth.vertices.size(); ++v) {
                squares += square_distance(truth.vertices[v], back.vertices[v]);
            }
        }
        return {nlohmann::json::parse(outcome.out)["rms_error"],
                1000 * std::sqrt(squares / (3 * 3 * 162))};
    }

    const TemporaryFolder temporary_;
    const std::string folder_ = temporary_.path();
};

// On a map, or gone far: the meshes come back to seven digits of their size, and the error printed
// is that of the files.
TEST_F(Reconstruct, TellsTheErrorOfTheFilesItWroteFarAway) {
    for (const bool travels : {false, true}) {
        move_to("far", [&](int i) {
            return travels ? Point{2e7 * i, 0, 0} : Point{5e5, 5.5e6, 0};
        });
        for (const std::string format : {"obj", "ply", "off"}) {
            const Errors errors = errors_in("far", format);
            EXPECT_LT(errors.written, 1e-2) << format << travels;
            // Neither is more than the rounding of float32 in the file that the error is told to.
            EXPECT_NEAR(errors.told, errors.written, 2e-3) << format << travels;
        }
    }
}

// Fifty sizes off, float32 in a PLY rounds to a few millionths of the size: more than what solving
// leaves.
TEST_F(Reconstruct, TellsTheErrorThatTheFormatAdds) {
    move_to("near", [](int i) { return Point{70.0 * i, 70.0 * i, 70.0 * i}; });
    const Errors ply = errors_in("near", "ply");
    EXPECT_GT(ply.written, 3 * errors_in("near", "obj").told);
    EXPECT_NEAR(ply.told, ply.written, 0.1 * ply.written);
}

// The default loses nothing, in every format, and puts each shape back where it stood.
TEST_F(Reconstruct, GivesTheInputBack) {
    for (const std::string format : {"obj", "ply", "off"}) {
        const Outcome outcome =
            run("reconstruct f.safetensors -o " + format + " --format " + format);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        for (int pose = 0; pose < 3; ++pose) EXPECT_LE(distance(format, pose, format), 1e-5);
        EXPECT_THAT(outcome.err, Not(HasSubstr("no mesh")));
    }
    ASSERT_EQ(run("reconstruct f.safetensors -o p --solver poisson").code, 0);
    EXPECT_GT(distance("p", 2, "obj"), 1e-4);
}

TEST_F(Reconstruct, ReportsErrorsOfBothSolversAndTheResidual) {
    const Outcome outcome = run("reconstruct f.safetensors -o out --json --frames 1:3");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report.at("shapes"), 2);
    EXPECT_EQ(report.at("solver"), "lossless");
    EXPECT_LE(report.at("rms_error").get<double>(), 1e-3);
    EXPECT_GT(report.at("rms_error_poisson").get<double>(), 0.1);
    EXPECT_LE(report.at("residual_max").get<double>(), 1e-6);
    EXPECT_EQ(report.at("shapes_without_mesh"), 0);
    EXPECT_EQ(report.at("shapes_not_converged"), 0);
    EXPECT_GT(report.at("ms_per_shape").get<double>(), 0);
}

// A feature file whose last shape has the average of two poses' features.
TEST_F(Reconstruct, SaysWhichFeaturesNoMeshHas) {
    {
        const SafetensorsFile file(path("f.safetensors"));
        const auto features = file.data<float>("features", {-1, -1, 9});
        std::vector<float> mixed(features.begin(), features.end());
        const std::size_t size = mixed.size() / 3;
        for (std::size_t i = 0; i < size; ++i) {
            mixed[2 * size + i] = 0.5F * (mixed[size + i] + mixed[2 * size + i]);
        }
        SafetensorsWriter writer;
        writer.add("features", file.shape("features"), std::span<const float>(mixed));
        writer.add("vertices", file.shape("vertices"), file.data<float>("vertices", {-1, -1, 3}));
        writer.add("reference", file.shape("reference"), file.data<double>("reference", {-1, 3}));
        writer.add("faces", file.shape("faces"), file.data<int>("faces", {-1, 3}));
        writer.add("rotation", file.shape("rotation"), file.data<double>("rotation", {-1, 3, 3}));
        writer.add("translation", file.shape("translation"),
                   file.data<double>("translation", {-1, 3}));
        writer.write(path("mixed.safetensors"));
    }
    const Outcome outcome = run("reconstruct mixed.safetensors -o out");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("1 of 3 shapes have features that no mesh has exactly"));
    EXPECT_THAT(outcome.out, HasSubstr("in 'shape_0002'"));
}

TEST_F(Reconstruct, MeetsHandlesWhereTheMeshesAreWritten) {
    write_file(path("h.json"),
               R"({"handles": [{"vertex": 4, "position": [0.5, 2, 1]},
                               {"vertex": 90, "position": [0, 0, 0], "weight": 0.01}]})");
    const Outcome outcome = run("reconstruct f.safetensors -o out --handles h.json --frames 2:3");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const Point held = read_mesh(path("out/pose_2.obj")).vertices[4];
    EXPECT_NEAR(held[0], 0.5, 1e-6);
    EXPECT_NEAR(held[1], 2, 1e-6);
    EXPECT_NEAR(held[2], 1, 1e-6);
}

TEST_F(Reconstruct, RefusesSenselessHandles) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"[", "is not valid JSON"},
        {R"({"handle": []})", "wanted an object with a list 'handles'"},
        {R"({"handles": []})", "names no handle"},
        {R"({"handles": [], "weight": 1})", "unknown key 'weight', wanted handles"},
        {R"({"handles": [3]})", "handles[0]: wanted an object"},
        {R"({"handles": [{"vertex": 162, "position": [0, 0, 0]}]})",
         "handles[0]: 'vertex' is 162, wanted 0 to 161"},
        {R"({"handles": [{"vertex": 1.5, "position": [0, 0, 0]}]})", "'vertex' is 1.5"},
        {R"({"handles": [{"vertex": 1, "position": [0, 0]}]})", "wanted three numbers"},
        {R"({"handles": [{"vertex": 1, "position": [0, 0, "x"]}]})", "wanted three numbers"},
        {R"({"handles": [{"vertex": 1, "position": [0, 0, 1e31]}]})", "wanted numbers up to 1e+30"},
        {R"({"handles": [{"vertex": 1, "position": [0, 0, 0], "weight": 0}]})", "'weight' is 0"},
        {R"({"handles": [{"vertex": 1, "position": [0, 0, 0], "wait": 2}]})", "unknown key 'wait'"},
        {R"({"handles": [{"vertex": 1, "position": [0, 0, 0]},
                         {"vertex": 1, "position": [1, 0, 0]}]})",
         "handles[1]: vertex 1 has handles[0] already"}};
    for (const auto& [text, message] : cases) {
        write_file(path("h.json"), text);
        const Outcome outcome = run("reconstruct f.safetensors -o out --handles h.json");
        EXPECT_EQ(outcome.code, 3) << text;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << text;
    }
    EXPECT_EQ(run("reconstruct f.safetensors -o out --handles nowhere.json").code, 4);
    const Outcome outcome =
        run("reconstruct f.safetensors -o out --handles h.json --solver poisson");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("--handles: got --solver poisson, wanted lossless"));
}

}  // namespace
}  // namespace mscomp
