// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/paths.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

constexpr const char* kTruth = "truth.json";
constexpr const char* kRotationTruth = "truth_rotation.safetensors";

/// What an earlier sequence in this folder says it is made of: together they would be none.
void drop_earlier(const std::string& folder, OutputFolder& output) {
    const std::string path = folder + "/" + kTruth;
    if (!path_exists(path)) return;
    const auto earlier = sound_json<nlohmann::json>(read_file(path));
    if (!earlier || !earlier->is_object() || !earlier->contains("frames")) return;
    output.drop(kRotationTruth);
    for (const auto& frame : earlier->at("frames")) {
        const std::string name = frame.is_string() ? frame.get<std::string>() : "";
        if (!name.empty() && name.find('/') == std::string::npos) output.drop(name + ".obj");
    }
}

void write_weights(const GeneratedSequence& generated, const std::string& path) {
    const std::size_t count = generated.component_names.size();
    nlohmann::json weights = nlohmann::json::array();
    for (std::size_t n = 0; n < generated.sequence.names.size(); ++n) {
        const auto row = generated.weights.begin() + static_cast<std::ptrdiff_t>(n * count);
        weights.push_back(std::vector<float>(row, row + static_cast<std::ptrdiff_t>(count)));
    }
    const nlohmann::json truth{{"names", generated.component_names},
                               {"scales", generated.scales},
                               {"frames", generated.sequence.names},
                               {"weights", weights}};
    write_file(path, json_text(truth, 1) + "\n");
}

void write_supports(const GeneratedSequence& generated, const std::string& path) {
    SafetensorsWriter writer;
    writer.add<float>("supports", {generated.component_count(), generated.sequence.vertex_count()},
                      generated.supports);
    writer.set_metadata("names", json_text(nlohmann::json(generated.component_names)));
    writer.write(path);
}

void write_rotation(const GeneratedSequence& generated, const std::string& path) {
    const RotationTruth& truth = generated.rotation_truth;
    const std::int64_t frames = generated.sequence.shape_count();
    const std::int64_t vertices = generated.sequence.vertex_count();
    SafetensorsWriter writer;
    writer.add<float>("rotation", {frames, vertices, kRotationDim}, truth.rotation);
    writer.add<std::uint8_t>("exact", {vertices}, truth.exact);
    if (!truth.features.empty()) {
        writer.add<float>("features", {frames, vertices, kFeatureDim}, truth.features);
    }
    writer.write(path);
}

}  // namespace

void write_generated(const GeneratedSequence& generated, const std::string& folder) {
    OutputFolder output(folder);
    drop_earlier(folder, output);
    const MeshSequence& sequence = generated.sequence;
    parallel_for(sequence.shape_count(), [&](std::int64_t n) {
        const auto place = at(n);
        write_obj(output.path(sequence.names[place] + ".obj"),
                  {sequence.shapes[place], sequence.faces});
    });
    write_weights(generated, output.path(kTruth));
    write_supports(generated, output.path("truth_supports.safetensors"));
    if (!generated.rotation_truth.rotation.empty()) {
        write_rotation(generated, output.path(kRotationTruth));
    }
    output.commit();
}

}  // namespace mscomp
