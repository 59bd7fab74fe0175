// SPDX-License-Identifier: MIT
// mscomp evaluate, and reconstruct --fit, as a user runs them on a small generated arm.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/points.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/eval/farthest_points.h"
#include "mscomp/eval/measures.h"
#include "mscomp/run/trained_run.h"

namespace mscomp {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

struct Outcome {
    int code = -1;
    std::string out, err;
};

/// "arm/frame_0007.obj"
std::string fmt_name(const char* stem, int frame) {
    return fmt::format("{}{:04}.obj", stem, frame);
}

/// One arm of 16 frames, every third of which trains, shared by all tests.
class MscompEvaluate : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new TemporaryFolder;
        write_file(path("config.yaml"),
                   "model: {kind: stacked-attention, levels: [{components: 4, sparsity_range: "
                   "0.3}, {components: 2, "
                   "sparsity_range: 0.2}]}\n"
                   "data: {features: arm.safetensors, split: {train: every, step: 3}}\n"
                   "train: {epochs: 30, batch: 6}\n");
        const std::string bin = MSCOMP_BIN_DIR;
        ok(shell(bin + "/acapfeat generate arm -o arm --frames 16 --vertices 500 --quiet"));
        ok(shell(bin + "/acapfeat extract arm -o arm.safetensors --quiet"));
        ok(mscomp("train config.yaml -o run --quiet"));
    }
    static void TearDownTestSuite() {
        delete folder_;
        folder_ = nullptr;
    }

    static std::string path(const std::string& name) { return *folder_ / name; }
    static Outcome shell(const std::string& command) {
        const std::string line = "cd '" + path("") + "' && ( " + command + " ) >'" + path(".out") +
                                 "' 2>'" + path(".err") + "'";
        const int status = std::system(line.c_str());
        EXPECT_TRUE(WIFEXITED(status)) << line;
        return {WEXITSTATUS(status), read_file(path(".out")), read_file(path(".err"))};
    }
    static Outcome mscomp(const std::string& arguments) {
        return shell(std::string(MSCOMP_BIN_DIR) + "/mscomp " + arguments);
    }
    static Outcome ok(Outcome outcome) {
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return outcome;
    }
    static json evaluated(const std::string& arguments) {
        return json::parse(ok(mscomp("evaluate " + arguments + " --json --quiet")).out);
    }
    static void refused(const std::string& arguments, int code, const std::string& message) {
        const Outcome outcome = mscomp(arguments);
        EXPECT_EQ(outcome.code, code) << arguments << ": " << outcome.err;
        EXPECT_THAT(outcome.err, HasSubstr(message)) << arguments;
    }

    static TemporaryFolder* folder_;
};
TemporaryFolder* MscompEvaluate::folder_ = nullptr;

/// A copy of the run with another filter.
std::string filtered(const std::string& set) {
    return "rm -rf other && cp -r run other && " MSCOMP_BIN_DIR
           "/mscomp train config.yaml -o other --resume --quiet --set filter." +
           set;
}

// The kept ones alone are all of them where all are kept, and give less back where few are.
TEST_F(MscompEvaluate, OfKeptComponentsAlone) {
    ok(shell(
        filtered("rule=strength --set filter.minimum_strength=0 --set filter.minimum_share=0")));
    const json all = evaluated("other"), same = evaluated("other --kept");
    EXPECT_EQ(all.at("kept_only"), false);
    EXPECT_EQ(same.at("kept_only"), true);
    ASSERT_EQ(same.at("components"), json({4, 8}));
    for (const char* fit : {"features", "vertices"}) {
        const double error = all[fit]["rms_error"];
        EXPECT_NEAR(same[fit]["rms_error"].get<double>(), error, 1e-3 * error) << fit;
    }
    ok(shell(filtered("refit_share=1 --set filter.alike=0.9")));
    const json few = evaluated("other --kept --components 1 --handles 20");
    EXPECT_LT(few["components"][0].get<int>() + few["components"][1].get<int>(), 12);
    EXPECT_GT(few["features"]["rms_error"], all["features"]["rms_error"]);
    EXPECT_EQ(evaluated("other")["features"]["rms_error"], all["features"]["rms_error"]);
    EXPECT_EQ(few["component_list"].size(), 12U);
    EXPECT_GE(few["features"]["by_components"][0]["rms_error"], few["features"]["rms_error"]);
    ok(shell(filtered("rule=strength --set filter.minimum_strength=100")));
    refused("evaluate other --kept", 2, "--kept: the run has no kept component");
}

// The names that scripts read.
TEST_F(MscompEvaluate, PrintsTheContract) {
    const json report = evaluated("run");
    EXPECT_EQ(report.at("set"), "arm");
    EXPECT_EQ(report.at("split"), "test");
    EXPECT_EQ(report.at("shapes"), 10);  // 16 less 0, 3, ..., 15
    EXPECT_EQ(report.at("kind"), "stacked-attention");
    ASSERT_EQ(report.at("components").size(), 2u);
    for (const char* fit : {"features", "vertices"}) {
        for (const char* key :
             {"rms_error", "sted", "sted_spatial", "sted_temporal", "mean_vertex_distance",
              "max_vertex_distance", "relative_squared_error_max", "relative_squared_error_mean",
              "support_mean"}) {
            ASSERT_TRUE(report.at(fit).contains(key)) << fit << " " << key;
            EXPECT_TRUE(report[fit][key].is_number()) << fit << " " << key;
            EXPECT_GT(report[fit][key], 0) << fit << " " << key;
        }
    }
    EXPECT_EQ(report.at("per_shape").size(), 10u);
    EXPECT_EQ(report["per_shape"][0].at("shape"), 1);
    EXPECT_EQ(report["per_shape"][0].at("name"), "frame_0001");
    EXPECT_EQ(report.at("component_list").size(), 4u + 8u);
    std::vector<int> kept{0, 0};
    for (const json& c : report["component_list"]) {
        for (const char* key : {"id", "level", "strength", "support", "localization_radius"}) {
            EXPECT_TRUE(c.contains(key)) << key;
        }
        if (c.at("kept")) ++kept[c.at("level")];
    }
    EXPECT_EQ(report["components"], json(kept));
    const json& cosine = report.at("cosine");
    const std::size_t count = cosine.at("ids").size();
    ASSERT_EQ(cosine.at("matrix").size(), count);
    double largest = 0;
    for (std::size_t k = 0; k < count; ++k) {
        ASSERT_EQ(cosine["matrix"][k].size(), count);
        EXPECT_NEAR(cosine["matrix"][k][k], 1, 1e-9);
        for (std::size_t l = 0; l < k; ++l) {
            EXPECT_EQ(cosine["matrix"][k][l], cosine["matrix"][l][k]);
            largest = std::max(largest, std::abs(cosine["matrix"][k][l].get<double>()));
        }
    }
    EXPECT_EQ(cosine.at("max"), largest);
}

// The vertices fit starts at the features fit and never goes farther away.
TEST_F(MscompEvaluate, VerticesFitIsNeverFartherForAnyShape) {
    for (const char* split : {"test", "train"}) {
        const json report = evaluated(std::string("run --split ") + split);
        EXPECT_LT(report["vertices"]["rms_error"], report["features"]["rms_error"]) << split;
        for (const json& row : report["per_shape"]) {
            EXPECT_LE(row["vertices"]["rms_error"].get<double>(),
                      row["features"]["rms_error"].get<double>() * (1 + 1e-9))
                << split << " " << row["name"];
        }
    }
}

// All fits stand beside each other, in this order, and the third one changes nothing of two.
TEST_F(MscompEvaluate, JointCodesAreAFitOfTheirOwn) {
    const json all = evaluated("run --fit all --components 2,12 --worst 2");
    json others = all;
    others.erase("codes");
    others["worst"].erase("codes");
    for (json& row : others["per_shape"]) row.erase("codes");
    EXPECT_EQ(others, evaluated("run --components 2,12 --worst 2"));
    for (const auto& [key, value] : all["features"].items()) {
        EXPECT_TRUE(all["codes"].contains(key)) << key;
    }
    EXPECT_LT(all["codes"]["relative_squared_error_mean"],
              all["features"]["relative_squared_error_mean"]);
    EXPECT_LT(all["vertices"]["rms_error"], all["codes"]["rms_error"]);
    EXPECT_EQ(all["worst"]["codes"].size(), 2u);
    // Of all components it is the fit without a limit, from the same start.
    EXPECT_NEAR(all["codes"]["by_components"][1]["rms_error"], all["codes"]["rms_error"], 1e-9);
    const json alone = evaluated("run --fit codes --components 2,12 --worst 2");
    EXPECT_EQ(alone["codes"], all["codes"]);
    EXPECT_FALSE(alone.contains("features"));
    const std::string text =
        ok(mscomp("evaluate run --quiet --fit all --worst 1 -o three --force")).out;
    EXPECT_LT(text.find("features fit"), text.find("codes fit"));
    EXPECT_LT(text.find("codes fit"), text.find("vertices fit"));
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = text.find('\n', begin);
        EXPECT_LE(end - begin, 100u) << text.substr(begin, end - begin);
        begin = end + 1;
    }
    EXPECT_THAT(read_file(path("three/table.csv")), HasSubstr(",codes_rms_error,"));
    EXPECT_THAT(read_file(path("three/errors.png")), testing::StartsWith("\x89PNG"));
}

// E_rms of meshes that reconstruct wrote is what evaluate says of the same fit and split.
TEST_F(MscompEvaluate, AgreesWithWhatReconstructWrites) {
    const json report = evaluated("run --fit all");
    const FeatureFile file(path("arm.safetensors"));
    for (const std::string fit : {"features", "codes", "vertices"}) {
        const json written = json::parse(ok(mscomp("reconstruct run arm.safetensors -o " + fit +
                                                   " --split test --json --quiet --fit " + fit))
                                             .out);
        EXPECT_EQ(written.at("fit"), fit);
        EXPECT_EQ(written.at("rms_error"), report[fit]["rms_error"]);
        EXPECT_EQ(written.at("relative_squared_error_max"),
                  report[fit]["relative_squared_error_max"]);
        if (fit != "features") {
            EXPECT_EQ(written.at("rms_error_features"), report["features"]["rms_error"]);
        }
        RmsError error(file.outline().reference.vertices);
        for (const json& row : report["per_shape"]) {
            error.add(
                points_of(file.vertices(row["shape"])),
                read_mesh(path(fit + "/" + row["name"].get<std::string>() + ".obj")).vertices);
        }
        EXPECT_NEAR(error.value(), report[fit]["rms_error"], 1e-4);
    }
}

// All components together are the whole model; of fewer, those of more can do no worse to the
// vertices (up to where a descent ends).
TEST_F(MscompEvaluate, ErrorFallsWithTheNumberOfComponents) {
    const json report = evaluated("run --components 1,4,12");
    for (const char* fit : {"features", "vertices"}) {
        const json& curve = report[fit].at("by_components");
        ASSERT_EQ(curve.size(), 3u);
        EXPECT_EQ(curve[0].at("n"), 1);
        EXPECT_EQ(curve[2].at("n"), 12);
        EXPECT_NEAR(curve[2].at("rms_error"), report[fit]["rms_error"],
                    1e-3 * report[fit]["rms_error"].get<double>());
        EXPECT_GT(curve[0].at("rms_error"), curve[2].at("rms_error"));
    }
    const json& vertices = report["vertices"]["by_components"];
    // One component alone leaves at most what the reference leaves; the strongest four, a good part
    // less.
    const FeatureFile file(path("arm.safetensors"));
    RmsError still(file.outline().reference.vertices);
    for (const json& row : report["per_shape"]) {
        still.add(points_of(file.vertices(row["shape"])), file.outline().reference.vertices);
    }
    EXPECT_LT(vertices[0]["rms_error"], 1.05 * still.value());
    EXPECT_LT(vertices[1]["rms_error"], 0.4 * still.value());
    EXPECT_GT(vertices[0]["rms_error"], vertices[1]["rms_error"]);
    EXPECT_GT(vertices[1]["rms_error"], 0.98 * vertices[2]["rms_error"].get<double>());
}

// More handles tell more, at most what all vertices tell.
TEST_F(MscompEvaluate, ErrorFallsWithTheNumberOfHandles) {
    const json report = evaluated("run --handles 4,60 --fit features");
    const json& curve = report.at("by_handles");
    ASSERT_EQ(curve.size(), 2u);
    EXPECT_EQ(curve[0].at("n"), 4);
    EXPECT_EQ(curve[1].at("n"), 60);
    EXPECT_GT(curve[0].at("rms_error"), curve[1].at("rms_error"));
    const double all = evaluated("run --fit vertices")["vertices"]["rms_error"];
    EXPECT_GT(curve[1].at("rms_error"), 0.98 * all);
    EXPECT_LT(curve[1].at("rms_error"), 2 * all);
    EXPECT_FALSE(report.contains("vertices"));
}

TEST_F(MscompEvaluate, ThreadsDoNotChangeADigit) {
    const std::string arguments =
        "evaluate run --fit all --components 3 --handles 8 --json --quiet --threads ";
    const std::string one = ok(mscomp(arguments + "1")).out;
    EXPECT_EQ(one, ok(mscomp(arguments + "3")).out);
}

// Temporal parts are for sequences; "auto" takes a split of every n-th shape for one.
TEST_F(MscompEvaluate, OrderDecidesAboutTheTemporalPart) {
    const json sequence = evaluated("run --fit features --split all");
    EXPECT_EQ(sequence.at("order"), "sequence");
    EXPECT_EQ(sequence["features"]["sted"],
              evaluated("run --fit features --split all --order sequence")["features"]["sted"]);
    const json set = evaluated("run --fit features --split all --order set");
    EXPECT_TRUE(set["features"]["sted"].is_null());
    EXPECT_TRUE(set["features"]["sted_temporal"].is_null());
    EXPECT_EQ(set["features"]["sted_spatial"], sequence["features"]["sted_spatial"]);
    ok(mscomp("train config.yaml -o all --quiet --set data.split.train=all --set train.epochs=2"));
    const json unordered = evaluated("all --fit features");
    EXPECT_EQ(unordered.at("order"), "set");
    EXPECT_EQ(unordered.at("split"), "all");
    EXPECT_EQ(unordered.at("shapes"), 16);
}

/// The temporal part of STED by its definition (docs/measures.md): t of the truth, t' of the
/// result.
double temporal_part(const std::vector<std::vector<Point>>& truth,
                     const std::vector<std::vector<Point>>& result, double radius) {
    const auto length = [&](const std::vector<std::vector<Point>>& all, std::size_t f,
                            std::size_t v) {
        double square = 0.002 * 0.002;
        for (std::size_t x = 0; x < 3; ++x) {
            square += std::pow((all[f + 1][v][x] - all[f][v][x]) / radius, 2);
        }
        return std::sqrt(square);
    };
    const std::size_t steps = truth.size() - 1, vertices = truth[0].size();
    double sum = 0;
    for (std::size_t v = 0; v < vertices; ++v) {
        for (std::size_t f = 0; f < steps; ++f) {
            double mean = 0;
            const std::size_t first = f == 0 ? 0 : f - 1, last = std::min(f + 1, steps - 1);
            for (std::size_t g = first; g <= last; ++g) mean += length(truth, g, v);
            mean /= static_cast<double>(last - first + 1);
            sum += std::abs(length(result, f, v) - length(truth, f, v)) / mean;
        }
    }
    return sum / static_cast<double>(steps * vertices);
}

/// Turned about z and moved, more from frame to frame.
std::vector<Point> marched(const std::vector<Point>& points, int frame) {
    const double angle = 0.2 * frame, c = std::cos(angle), s = std::sin(angle);
    std::vector<Point> result;
    for (const Point& p : points) {
        result.push_back({c * p[0] - s * p[1] + 0.3 * frame, s * p[0] + c * p[1], p[2]});
    }
    return result;
}

// Extraction aligns every frame to the reference; the truth of the temporal part is where the
// frames of the input really were.
TEST_F(MscompEvaluate, TemporalPartIsThatOfTheFramesWhereTheyWere) {
    fs::create_directory(path("march"));
    std::vector<std::vector<Point>> truth;
    for (int f = 0; f < 16; ++f) {
        TriangleMesh mesh = read_mesh(path(fmt_name("arm/frame_", f)));
        mesh.vertices = marched(mesh.vertices, f);
        truth.push_back(mesh.vertices);
        write_obj(path(fmt_name("march/frame_", f)), mesh);
    }
    ok(shell(std::string(MSCOMP_BIN_DIR) + "/acapfeat extract march -o march.safetensors --quiet"));
    ok(
        mscomp("train config.yaml -o march.run --quiet --set data.features=march.safetensors "
               "--set train.epochs=5"));
    ok(mscomp("reconstruct march.run march.safetensors -o marched --quiet"));
    std::vector<std::vector<Point>> result;
    for (int f = 0; f < 16; ++f) {
        const TriangleMesh mesh = read_mesh(path(fmt_name("marched/frame_", f)));
        result.push_back(aligned_to(truth[static_cast<std::size_t>(f)], mesh.vertices));
    }
    const double radius = 1 / unit_ball_scale(truth[0]);
    const json report = evaluated("march.run --split all --fit features");
    const double wanted = temporal_part(truth, result, radius);
    EXPECT_NEAR(report["features"]["sted_temporal"], wanted, 1e-4 * wanted);
    std::vector<std::vector<Point>> aligned_truth, aligned_result;
    for (std::size_t f = 0; f < truth.size(); ++f) {
        aligned_truth.push_back(aligned_to(truth[0], truth[f]));
        aligned_result.push_back(aligned_to(aligned_truth[f], result[f]));
    }
    EXPECT_GT(temporal_part(aligned_truth, aligned_result, radius), 1.1 * wanted)
        << "aligned one by one they move less";
}

// The undeformed reference, measured like a result: what an error has to be compared with. It is at
// zero for [A] eq. 8 only if the ranges of the training shapes lie symmetrically around it.
TEST_F(MscompEvaluate, TheReferenceStandsBesideTheFits) {
    const json report = evaluated("run --split all --fit features");
    const FeatureFile file(path("arm.safetensors"));
    const FeatureSet& set = file.outline();
    std::array<double, 2> low{1e9, 1e9}, high{-1e9, -1e9};
    for (int m = 0; m < 16; m += 3) {  // the training shapes
        const std::span<const float> row = file.shape(m);
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::size_t group = i % 9 < 3 ? 0 : 1;
            low[group] = std::min(low[group], static_cast<double>(row[i]));
            high[group] = std::max(high[group], static_cast<double>(row[i]));
        }
    }
    double mean = 0, most = 0;
    RmsError rms(set.reference.vertices);
    for (int m = 1; m < 16; ++m) {  // 0 is the reference
        const std::span<const float> row = file.shape(m);
        double error = 0, size = 0;
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::size_t group = i % 9 < 3 ? 0 : 1;
            const double half = (high[group] - low[group]) / 2;
            const double middle = (high[group] + low[group]) / 2;
            const double reference = i % 9 == 3 || i % 9 == 6 || i % 9 == 8 ? 1 : 0;
            const double x = (static_cast<double>(row[i]) - middle) / half;
            const double y = (reference - middle) / half;
            error += (x - y) * (x - y);
            size += x * x;
        }
        mean += error / size / 15;
        most = std::max(most, error / size);
    }
    for (int m = 0; m < 16; ++m) rms.add(points_of(file.vertices(m)), set.reference.vertices);
    const json& reference = report.at("reference");
    EXPECT_NEAR(reference.at("relative_squared_error_mean"), mean, 1e-5 * mean);
    EXPECT_NEAR(reference.at("relative_squared_error_max"), most, 1e-5 * most);
    EXPECT_LT(most, 0.999) << "it is not 1";
    EXPECT_NEAR(reference.at("rms_error"), rms.value(), 1e-9 * rms.value());
    const std::string text = ok(mscomp("evaluate run --split all --fit features --quiet")).out;
    EXPECT_THAT(text, HasSubstr("reference\n"));
    EXPECT_THAT(text, HasSubstr(fmt::format("{:>10.5f}\n", mean)));
}

// 10 shapes, however many passes each has to go through.
TEST_F(MscompEvaluate, ProgressCountsShapes) {
    const std::string shown = ok(mscomp("evaluate run --components 2 --handles 8")).err;
    EXPECT_THAT(shown, HasSubstr("10/10"));
    EXPECT_THAT(shown, testing::Not(HasSubstr("/20")));
    EXPECT_THAT(shown, testing::Not(HasSubstr("/40")));
}

TEST_F(MscompEvaluate, WritesTablesAndAPicture) {
    const json report = evaluated("run -o measures --worst 2");
    const std::string table = read_file(path("measures/table.csv"));
    EXPECT_THAT(table, testing::StartsWith("shape,name,features_rms_error,"));
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 10);
    const std::string components = read_file(path("measures/components.csv"));
    EXPECT_EQ(std::count(components.begin(), components.end(), '\n'), 1 + 12);
    EXPECT_THAT(read_file(path("measures/errors.png")), testing::StartsWith("\x89PNG"));
    for (const char* fit : {"features", "vertices"}) {
        const json& worst = report.at("worst").at(fit);
        ASSERT_EQ(worst.size(), 2u);
        double largest = 0;
        for (const json& row : report["per_shape"]) {
            largest = std::max(largest, row[fit]["rms_error"].get<double>());
        }
        EXPECT_EQ(worst[0].at("rms_error"), largest);
        EXPECT_GE(worst[0].at("rms_error"), worst[1].at("rms_error"));
    }
    refused("evaluate run -o measures", 2, "--force");
    EXPECT_EQ(read_file(path("measures/table.csv")), table);
    ok(mscomp("evaluate run -o measures --force --quiet --worst 0 --fit features"));
    EXPECT_THAT(read_file(path("measures/table.csv")), testing::Not(HasSubstr("vertices_")));
}

TEST_F(MscompEvaluate, TextNamesUnitsAndWorstShapes) {
    const std::string text = ok(mscomp("evaluate run --quiet --worst 1 --components 2")).out;
    for (const char* part :
         {"features fit", "vertices fit", "E_rms (x1000, unit ball)", "mesh units", "worst shapes",
          "frame_00", "strongest", "mean support", "cosine similarity"}) {
        EXPECT_THAT(text, HasSubstr(part));
    }
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = text.find('\n', begin);
        EXPECT_LE(end - begin, 100u) << text.substr(begin, end - begin);
        begin = end + 1;
    }
}

/// A table of weights of shapes from `first` on: a constant, and `second`.
std::string csv(const std::vector<double>& second, bool header, std::size_t first) {
    std::string text = header ? "\xEF\xBB\xBF\"constant\",told\r\n" : "";
    for (std::size_t n = first; n < second.size(); ++n) {
        text += "1.5," + std::to_string(second[n]) + "\r\n";
    }
    return text;
}

// Rows with and without the reference mean the same; a weight that never changes is told by none.
TEST_F(MscompEvaluate, KnownUnitsAreToldByTheirRows) {
    const json whole = evaluated("run --split all");
    std::vector<double> weight;
    for (const json& row : whole["per_shape"]) weight.push_back(row["shape"]);
    weight[0] = 0;
    write_file(path("all.csv"), csv(weight, true, 0));
    write_file(path("later.csv"), csv(weight, false, 1));
    const json a = evaluated("run --split all --units all.csv").at("units");
    const json b = evaluated("run --units later.csv").at("units");
    const json c = evaluated("run --units all.csv").at("units");
    EXPECT_EQ(a.at("units"), 2);
    EXPECT_EQ(a.at("varying"), 1);
    for (const char* fit : {"features", "vertices"}) {
        ASSERT_EQ(a.at(fit).at("list").size(), 2u);
        EXPECT_EQ(a[fit]["list"][0]["unit"], "constant");
        EXPECT_EQ(a[fit]["list"][0]["best"]["correlation"], 0);
        EXPECT_EQ(a[fit]["list"][1]["unit"], "told");
        EXPECT_EQ(b[fit]["list"][1]["unit"], "1");
        EXPECT_EQ(b[fit]["list"][1]["best"], c[fit]["list"][1]["best"]);
        const double best = a[fit]["list"][1]["best"]["correlation"];
        EXPECT_GT(best, 0);
        EXPECT_EQ(a[fit]["matched"], best >= 0.9 ? 1 : 0);
    }
    for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
             {"1\n2\n3\n", "3 rows of weights, wanted 16"},
             {"a,b\n1,2\n1\n", "wrong.csv:3: 1 weights, wanted 2"},
             {"a\n1\nx\n", "wrong.csv:3: got \"x\", wanted a number"},
             {"a\n1\nnan\n", "wrong.csv:3: got \"nan\", wanted a number"},
             {"", "0 rows of weights"}}) {
        write_file(path("wrong.csv"), text);
        refused("evaluate run --units wrong.csv", 3, message);
    }
    refused("evaluate run --units nowhere.csv", 4, "nowhere.csv");
}

/// A truth.json beside its supports (U,V).
void write_truth(const std::string& path, const json& truth, const std::vector<float>& supports) {
    write_file(path, truth.dump());
    SafetensorsWriter writer;
    const auto count = static_cast<std::int64_t>(truth["names"].size());
    writer.add<float>("supports", {count, static_cast<std::int64_t>(supports.size()) / count},
                      supports);
    writer.write(path.substr(0, path.size() - 5) + "_supports.safetensors");
}

// What has the weights of a component, and lies where it does, is found as this one, on its level.
TEST_F(MscompEvaluate, ComponentsThatAreTheTruthAreFoundAsIt) {
    TrainedRun run = open_run(path("run"));
    const std::vector<Component> components = run.components();
    const FeatureFile file(path("arm.safetensors"));
    const auto vertices = static_cast<std::size_t>(file.vertex_count());
    json truth{{"names", json::array()},
               {"scales", json::array()},
               {"frames", file.outline().names},
               {"weights", std::vector<json>(16, json::array())}};
    std::vector<float> supports;
    std::vector<std::string> ids;
    std::vector<int> per_level(2, 0);
    // Backwards: their order must not be that of the components.
    for (auto c = components.rbegin(); c != components.rend(); ++c) {
        std::vector<float> lengths(vertices);
        for (std::size_t v = 0; v < vertices; ++v) {
            double square = 0;
            for (std::size_t i = 9 * v; i < 9 * v + 9; ++i) {
                square += std::pow(static_cast<double>(c->difference[i]), 2);
            }
            lengths[v] = static_cast<float>(std::sqrt(square));
        }
        const float most = *std::max_element(lengths.begin(), lengths.end());
        const auto rests = std::count(lengths.begin(), lengths.end(), 0.0F);
        if (!(most > 0) || 2 * rests < static_cast<std::ptrdiff_t>(vertices)) continue;
        for (const float length : lengths) supports.push_back(length / most);
        ids.push_back(c->id);
        ++per_level[static_cast<std::size_t>(c->level)];
        truth["names"].push_back("as " + c->id);
        truth["scales"].push_back(c->level);
        for (int n = 0, m = 0; n < 16; ++n) {
            const bool is_trained = n % 3 == 0;
            truth["weights"][static_cast<std::size_t>(n)].push_back(
                is_trained ? static_cast<double>(
                                 run.file.codes().shape(m++)[static_cast<std::size_t>(c->code)])
                           : 7.0);
        }
    }
    ASSERT_GE(per_level[0], 2);
    ASSERT_GE(per_level[1], 2);
    write_truth(path("planted.json"), truth, supports);
    const json found =
        evaluated("run --split train --fit features --truth planted.json").at("truth");
    EXPECT_EQ(found["components"], ids.size());
    EXPECT_EQ(found["varying"], ids.size());
    for (std::size_t u = 0; u < ids.size(); ++u) {
        const json& overlapping = found["by_overlap"]["list"][u];
        EXPECT_EQ(overlapping["component"], ids[u]);
        EXPECT_EQ(overlapping["iou"], 1) << ids[u];
        EXPECT_NEAR(overlapping["soft_iou"], 1, 1e-5) << ids[u];
        const json& told = found["features"]["list"][u];
        EXPECT_EQ(told["one_to_one"]["component"], ids[u]);
        EXPECT_NEAR(told["one_to_one"]["correlation"], 1, 1e-4) << ids[u];
        EXPECT_EQ(told["one_to_one"]["iou"], 1) << ids[u];
        EXPECT_EQ(told["by_overlap"]["component"], ids[u]);
        EXPECT_EQ(told["by_overlap"]["correlation"], told["one_to_one"]["correlation"]);
    }
    for (const json& matches : {found["by_overlap"], found["features"]}) {
        for (const std::size_t scale : {0U, 1U}) {
            const json& of_scale = matches[scale == 0 ? "coarse" : "fine"];
            std::vector<int> levels(2, 0);
            levels[scale] = per_level[scale];
            EXPECT_EQ(of_scale["components"], per_level[scale]);
            EXPECT_EQ(of_scale["per_level"], json(levels));
            EXPECT_EQ(of_scale["at_scale"], per_level[scale]);
            EXPECT_EQ(of_scale["iou"], 1);
        }
    }
    EXPECT_EQ(found["features"]["fine"]["matched_one_to_one"], per_level[1]);
    EXPECT_NEAR(found["features"]["coarse"]["correlation"], 1, 1e-4);

    // The other way round: what is coarse is called fine.
    for (json& scale : truth["scales"]) scale = 1 - scale.get<int>();
    write_truth(path("swapped.json"), truth, supports);
    const json swapped =
        evaluated("run --split train --fit features --truth swapped.json").at("truth");
    EXPECT_EQ(swapped["by_overlap"]["coarse"]["at_scale"], 0);
    EXPECT_EQ(swapped["by_overlap"]["coarse"]["per_level"], json({0, per_level[1]}));
}

// Weights are told by the same table as with --units; frames by their names, whatever their order.
TEST_F(MscompEvaluate, TruthsOfFramesAreToldByTheirNames) {
    json truth = json::parse(read_file(path("arm/truth.json")));
    std::string csv;
    for (const json& row : truth["weights"]) {
        for (const json& weight : row) csv += weight.dump() + (&weight == &row.back() ? "\n" : ",");
    }
    write_file(path("weights.csv"), csv);
    json report = evaluated("run --truth arm/truth.json --units weights.csv");
    json& found = report["truth"];
    EXPECT_EQ(found["components"], 12);
    EXPECT_EQ(found["varying"], report["units"]["varying"]);
    for (const char* fit : {"features", "vertices"}) {
        EXPECT_EQ(found[fit]["matched"], report["units"][fit]["matched"]);
        double iou[2] = {0, 0}, correlation[2] = {0, 0};
        for (std::size_t u = 0; u < 12; ++u) {
            const json& told = found[fit]["list"][u];
            const json& unit = report["units"][fit]["list"][u];
            EXPECT_EQ(told["unit"], truth["names"][u]);
            for (const char* match : {"best", "one_to_one"}) {
                EXPECT_EQ(told[match]["component"], unit[match]["component"]);
                EXPECT_EQ(told[match]["correlation"], unit[match]["correlation"]);
            }
            iou[u < 5 ? 0 : 1] += told["one_to_one"]["iou"].get<double>();
            correlation[u < 5 ? 0 : 1] += told["one_to_one"]["correlation"].get<double>();
        }
        EXPECT_NEAR(found[fit]["coarse"]["iou"], iou[0] / 5, 1e-12);
        EXPECT_NEAR(found[fit]["fine"]["iou"], iou[1] / 7, 1e-12);
        EXPECT_NEAR(found[fit]["coarse"]["correlation"], correlation[0] / 5, 1e-12);
        EXPECT_NEAR(found[fit]["fine"]["correlation"], correlation[1] / 7, 1e-12);
        EXPECT_EQ(found[fit]["coarse"]["matched_one_to_one"].get<int>() +
                      found[fit]["fine"]["matched_one_to_one"].get<int>(),
                  report["units"][fit]["matched_one_to_one"]);
    }
    std::reverse(truth["frames"].begin(), truth["frames"].end());
    std::reverse(truth["weights"].begin(), truth["weights"].end());
    fs::create_directories(path("turned"));
    write_file(path("turned/truth.json"), truth.dump());
    fs::copy_file(path("arm/truth_supports.safetensors"),
                  path("turned/truth_supports.safetensors"));
    json turned = evaluated("run --truth turned/truth.json").at("truth");
    turned["file"] = found["file"];
    EXPECT_EQ(turned, found);

    const std::string text = ok(mscomp("evaluate run --quiet --truth arm/truth.json")).out;
    for (const char* part : {"12 true components", "by overlap", "by codes, vertices", "coarse",
                             " of 7", "ripple_forearm", "|corr.|"}) {
        EXPECT_THAT(text, HasSubstr(part));
    }
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

TEST_F(MscompEvaluate, RefusesATruthOfSomethingElse) {
    const json truth = json::parse(read_file(path("arm/truth.json")));
    write_file(path("alone.json"), truth.dump());
    refused("evaluate run --truth alone.json", 4, "alone_supports.safetensors");
    write_truth(path("small.json"), truth, std::vector<float>(12 * 10));
    refused("evaluate run --truth small.json", 3,
            "small_supports.safetensors: tensor 'supports' has shape [12, 10], wanted [12, ");
    json other = truth;
    other["frames"][3] = "elsewhere";
    write_truth(path("other.json"), other, std::vector<float>(12 * 10));
    refused("evaluate run --truth other.json", 3,
            "other.json: names no frame 'frame_0003', a shape of ");
    write_file(path("none.json"), "{}");
    refused("evaluate run --truth none.json", 3, "none.json: wanted an object with the lists");
    refused("evaluate run --truth nowhere.json", 4, "nowhere.json");
}

TEST_F(MscompEvaluate, AnotherFileOfTheSameMeshIsTakenWhole) {
    FeatureSet set = read_features(path("arm.safetensors"));
    const auto row = static_cast<std::size_t>(set.vertex_count());
    set.features.resize(5 * row * kFeatureDim);
    set.vertices.resize(5 * row * 3);
    set.names.resize(5);
    set.rotation.resize(5);
    set.translation.resize(5);
    for (std::vector<double>* numbers :
         {&set.principal_energy, &set.propagation_energy, &set.relaxation_energy,
          &set.consistency_energy, &set.consistency_gap, &set.largest_jump, &set.large_jumps,
          &set.inherent_jumps, &set.removable_jumps}) {
        if (numbers->size() > 5) numbers->resize(5);
    }
    write_features(path("few.safetensors"), set);
    const json report = evaluated("run few.safetensors --fit features");
    EXPECT_EQ(report.at("split"), "all");
    EXPECT_EQ(report.at("shapes"), 5);
    refused("evaluate run few.safetensors --split test", 2, "few.safetensors is not the file");
    refused("evaluate run few.safetensors --split train", 2, "--split all");
    std::swap(set.reference.faces[0], set.reference.faces[1]);
    write_features(path("other.safetensors"), set);
    refused("evaluate run other.safetensors", 3, "other faces");
}

TEST_F(MscompEvaluate, RefusesWhatItCannotDo) {
    refused("evaluate run --components 0", 2, "--components: got 0, wanted 1 to 12");
    refused("evaluate run --components 3,13", 2, "--components: got 13, wanted 1 to 12");
    refused("evaluate run --handles 2", 2, "--handles: got 2, wanted 3 to ");
    refused("evaluate run --split tests", 2, "--split");
    refused("evaluate run --fit both --order sometimes", 2, "--order");
    refused("evaluate nowhere", 4, "nowhere");
    for (const std::string fit : {"codes", "vertices"}) {
        refused("reconstruct run arm.safetensors -o out --levels 1 --fit " + fit, 2,
                "--levels: got --fit " + fit);
    }
    refused("reconstruct run arm.safetensors -o out --fit both", 2, "--fit");
    refused("evaluate run --fit code", 2, "--fit");
    ok(mscomp("train config.yaml -o all2 --quiet --set data.split.train=all --set train.epochs=2"));
    refused("evaluate all2 --split test", 2, "has no shapes");
    fs::rename(path("arm.safetensors"), path("moved.safetensors"));
    refused("evaluate run", 4, "name it after the run");
    const json report = evaluated("run moved.safetensors --fit features");
    EXPECT_EQ(report.at("split"), "test") << "the same data under another name";
    fs::rename(path("moved.safetensors"), path("arm.safetensors"));
}

TEST_F(MscompEvaluate, InterruptedItWritesNothing) {
    const Outcome stopped = shell(
        std::string(MSCOMP_BIN_DIR) +
        "/mscomp evaluate run -o unfinished --handles 5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,"
        "20,21,22,23,24,25,26,27,28,29,30,31,32,33,34,35,36,37,38,39,40 --threads 1 & "
        "pid=$!; for i in 1 2 3 4 5 6; do sleep 0.3; kill -INT $pid; done; wait $pid");
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_FALSE(fs::exists(path("unfinished")));
}

}  // namespace
}  // namespace mscomp
