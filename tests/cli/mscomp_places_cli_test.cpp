// SPDX-License-Identifier: MIT
// Meshes with a UV seam, with vertices that no face uses and with pieces, through the commands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
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
#include "seamed_meshes.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

constexpr int kAround = 16, kRings = 15;
constexpr const char* kSmall =
    "--set 'data.split={train: every, step: 2}' --set 'model.levels=[{components: 4, "
    "sparsity_range: 0.4}]' "
    "--set train.epochs=40";

/// A tube of radius 1 that bends and bulges, frame by frame.
Point deformed(const Point& p, int frame) {
    const double bend = 0.15 * std::sin(0.7 * frame) * p[2];
    const double bulge =
        1 + 0.3 * std::sin(1.3 * frame + 1) * std::exp(-square_distance(p, {1, 0, 3}));
    const double x = bulge * p[0], y = bulge * p[1];
    return {std::cos(bend) * x + std::sin(bend) * p[2], y,
            std::cos(bend) * p[2] - std::sin(bend) * x};
}

class PlacesCommands : public testing::Test {
  protected:
    std::string run(const std::string& command) const {
        const std::string line = "cd '" + folder_.path() + "' && PATH='" + MSCOMP_BIN_DIR +
                                 "':$PATH && (" + command + ") 2>err >out";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << command << "\n"
                                                                   << read_file(folder_ / "err");
        return read_file(folder_ / "out");
    }
    std::string errors() const { return read_file(folder_ / "err"); }
    void write_frames(const std::string& name, const TriangleMesh& mesh, int frames) const {
        for (int frame = 0; frame < frames; ++frame) {
            TriangleMesh moved = mesh;
            for (Point& p : moved.vertices) p = deformed(p, frame);
            put(name, frame, moved);
        }
    }
    void put(const std::string& name, int frame, const TriangleMesh& mesh) const {
        fs::create_directories(folder_ / name);
        write_obj(folder_ / (name + "/f" + std::to_string(frame) + ".obj"), mesh);
    }
    void train(const std::string& name, const std::string& kind) const {
        run("acapfeat extract " + name + " -o " + name + ".safetensors --quiet --force");
        run("mscomp init " + kind + " > " + kind + ".yaml");
        run("mscomp train " + kind + ".yaml -o " + name + "." + kind +
            ".run --quiet --set data.features=" + name + ".safetensors " +
            (kind == "stacked-attention" ? kSmall
                                         : "--set train.epochs=40 --set model.components=4"));
    }
    json evaluated(const std::string& run_folder) const {
        return json::parse(
            run("mscomp evaluate " + run_folder + " --split all --fit features --quiet --json"));
    }

    TemporaryFolder folder_;
};

/// The largest gap between the two columns of vertices that lie on each other.
double seam_gap(const TriangleMesh& mesh) {
    double largest = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const auto first = static_cast<std::size_t>(ring * (kAround + 1));
        const double square = square_distance(mesh.vertices[first], mesh.vertices[first + kAround]);
        largest = std::max(largest, std::sqrt(square));
    }
    return largest;
}

// The tube has a radius of about 1: a gap of 1 % of it would be 0.01.
TEST_F(PlacesCommands, NoComponentOpensASeam) {
    write_frames("seam", shapes::seamed_tube(kAround, kRings, 1, 5), 8);
    EXPECT_THAT(run("acapfeat check seam"), HasSubstr("15 vertices lie on another one"));
    run("acapfeat extract seam -o seen.safetensors");
    EXPECT_THAT(errors(), HasSubstr("2 boundaries of together 32 edges"));
    for (const std::string kind : {"stacked-attention", "spectral-vae"}) {
        train("seam", kind);
        const std::string of_run = "seam." + kind + ".run";
        run("mscomp export-components " + of_run + " -o " + kind + ".out --all --quiet");
        int meshes = 0;
        double moved = 0;
        const TriangleMesh reference = read_mesh(folder_ / "seam/f0.obj");
        for (const auto& entry : fs::directory_iterator(folder_ / (kind + ".out"))) {
            if (entry.path().extension() != ".ply") continue;
            const TriangleMesh mesh = read_mesh(entry.path().string());
            ASSERT_EQ(mesh.faces, reference.faces);
            EXPECT_LT(seam_gap(mesh), 1e-6) << entry.path();
            for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
                moved = std::max(moved, square_distance(mesh.vertices[v], reference.vertices[v]));
            }
            ++meshes;
        }
        EXPECT_GE(meshes, 8);
        EXPECT_GT(moved, 1e-4);
        run("mscomp reconstruct " + of_run + " seam.safetensors -o " + kind + ".back --quiet");
        run("mscomp sample " + of_run + " -n 1 -o " + kind + ".samples --quiet");
        EXPECT_LT(seam_gap(read_mesh(folder_ / (kind + ".back/f3.obj"))), 1e-6);
        EXPECT_LT(seam_gap(read_mesh(folder_ / (kind + ".samples/sample_0.obj"))), 1e-6);
    }
}

/// A vertex before all others, which no face uses and which is elsewhere in every frame.
TriangleMesh with_far_vertex(TriangleMesh mesh, int frame) {
    mesh.vertices.insert(mesh.vertices.begin(), {1e4 * (1 + frame), -2e4, 3e4});
    for (Face& face : mesh.faces) {
        for (int& corner : face) ++corner;
    }
    return mesh;
}

TEST_F(PlacesCommands, AFarVertexWithoutAFaceChangesNoNumberAndNoPicture) {
    // Of one name, which pictures show.
    const TriangleMesh tube = shapes::cylinder(kAround, kRings, 1, 5, true);
    write_frames("plain/set", tube, 8);
    for (int frame = 0; frame < 8; ++frame) {
        const std::string name = "/set/f" + std::to_string(frame) + ".obj";
        put("far/set", frame, with_far_vertex(read_mesh(folder_ / ("plain" + name)), frame));
    }
    for (const std::string of : {"plain", "far"}) {
        const std::string set = of + "/set", of_run = set + ".stacked-attention.run";
        train(set, "stacked-attention");
        run("acapfeat reconstruct " + set + ".safetensors -o " + of + "/back --json >" + of +
            "/back.json");
        run("mscomp export-components " + of_run + " -o " + of + "/components --quiet");
        run("mscomp synthesize " + of_run + " --sheet " + of + "/sheet.png --quiet");
    }
    EXPECT_EQ(evaluated("far/set.stacked-attention.run")["features"],
              evaluated("plain/set.stacked-attention.run")["features"]);
    // A true component at one end, and what it says of the vertex that is on no surface.
    for (const std::string of : {"plain", "far"}) {
        std::vector<float> support(of == "far" ? 1 : 0, 1.0F);
        for (const Point& p : tube.vertices) support.push_back(p[2] > 3 ? 1.0F : 0.0F);
        SafetensorsWriter writer;
        writer.add<float>("supports", {1, static_cast<std::int64_t>(support.size())}, support);
        writer.write(folder_ / (of + "/truth_supports.safetensors"));
        json truth{{"names", {"end"}}, {"scales", {0}}, {"frames", json::array()}};
        for (int frame = 0; frame < 8; ++frame) {
            truth["frames"].push_back("f" + std::to_string(frame));
            truth["weights"].push_back({frame});
        }
        write_file(folder_ / (of + "/truth.json"), truth.dump());
    }
    const auto localised = [&](const std::string& of) {
        return json::parse(run("mscomp evaluate " + of + "/set.stacked-attention.run --truth " +
                               of + "/truth.json --fit features --quiet --json"))
            .at("truth")
            .at("by_overlap");
    };
    EXPECT_EQ(localised("far"), localised("plain"));
    EXPECT_GT(localised("far").at("coarse").at("iou"), 0.3);
    for (const char* picture : {"/components/overview.png", "/sheet.png"}) {
        EXPECT_TRUE(read_file(folder_ / ("far" + std::string(picture))) ==
                    read_file(folder_ / ("plain" + std::string(picture))))
            << picture;
    }
    const auto back_error = [&](const std::string& of) {
        return json::parse(read_file(folder_ / (of + "/back.json")))["rms_error"].get<double>();
    };
    EXPECT_NEAR(back_error("far"), back_error("plain"), 1e-6 * back_error("plain"));
    const TriangleMesh truth = read_mesh(folder_ / "far/set/f3.obj");
    const TriangleMesh back = read_mesh(folder_ / "far/back/f3.obj");
    EXPECT_EQ(back.faces, truth.faces);
    EXPECT_LT(square_distance(back.vertices[0], truth.vertices[0]), 1e-2);  // float32 there
    EXPECT_LT(square_distance(back.vertices[9], truth.vertices[9]), 1e-10);
    const json checked = json::parse(run("acapfeat check far/set --json"));
    const json of_plain = json::parse(run("acapfeat check plain/set --json"));
    EXPECT_EQ(checked["unit_ball_scale"], of_plain["unit_ball_scale"]);
}

/// A tube with a ball beside it.
TriangleMesh tube_and_ball() {
    TriangleMesh mesh = shapes::cylinder(kAround, kRings, 1, 5, true);
    const int first = mesh.vertex_count();
    const TriangleMesh ball = shapes::icosphere(1);
    for (const Point& p : ball.vertices) {
        mesh.vertices.push_back({2 + 0.5 * p[0], 0.5 * p[1], 2 + 0.5 * p[2]});
    }
    for (const Face& f : ball.faces)
        mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
    return mesh;
}

// What features do not show is an error, too, and not taken from the truth.
TEST_F(PlacesCommands, APieceThatMovesByItselfCounts) {
    const TriangleMesh mesh = tube_and_ball();
    write_frames("still", mesh, 8);
    for (int frame = 0; frame < 8; ++frame) {
        TriangleMesh moved = read_mesh(folder_ / ("still/f" + std::to_string(frame) + ".obj"));
        for (std::size_t v = moved.vertices.size() - 42; v < moved.vertices.size(); ++v) {
            moved.vertices[v][1] += 0.4 * std::sin(2.0 * frame);
        }
        put("loose", frame, moved);
    }
    train("still", "stacked-attention");
    run("acapfeat extract loose -o loose.safetensors --quiet");
    const auto both_fits = [&](const std::string& set) {
        return json::parse(run("mscomp evaluate still.stacked-attention.run " + set +
                               ".safetensors --split all --quiet --json --fit both"));
    };
    const json still = both_fits("still"), loose = both_fits("loose");
    for (const char* fit : {"features", "vertices"}) {
        EXPECT_GT(loose[fit]["rms_error"].get<double>(), 2 + still[fit]["rms_error"].get<double>())
            << fit;
    }
}

}  // namespace
}  // namespace mscomp
