// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

void write_weights(const GeneratedSequence& generated, const std::string& path) {
    const std::size_t count = generated.component_names.size();
    nlohmann::json truth;
    truth["names"] = generated.component_names;
    truth["scales"] = generated.scales;
    truth["frames"] = generated.sequence.names;
    truth["weights"] = nlohmann::json::array();
    for (std::size_t n = 0; n < generated.sequence.names.size(); ++n) {
        const auto row = generated.weights.begin() + static_cast<std::ptrdiff_t>(n * count);
        truth["weights"].push_back(
            std::vector<float>(row, row + static_cast<std::ptrdiff_t>(count)));
    }
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
    const MeshSequence& sequence = generated.sequence;
    parallel_for(sequence.shape_count(), [&](std::int64_t n) {
        const auto place = at(n);
        write_obj(fmt::format("{}/{}.obj", folder, sequence.names[place]),
                  {sequence.shapes[place], sequence.faces});
    });
    write_weights(generated, folder + "/truth.json");
    write_supports(generated, folder + "/truth_supports.safetensors");
    if (!generated.rotation_truth.rotation.empty()) {
        write_rotation(generated, folder + "/truth_rotation.safetensors");
    }
}

}  // namespace mscomp
