// SPDX-License-Identifier: MIT
// Trains a model on every other shape of a feature file, says how well it gives back the others,
// and writes the mesh of the end of its strongest component: train_and_decode FEATURES RUN MESH.obj
#include <mscomp/acap/mesh/mesh_io.h>
#include <mscomp/base/error.h>
#include <mscomp/config/config_file.h>
#include <mscomp/model/components.h>
#include <mscomp/model/synthesis.h>
#include <mscomp/report/evaluation.h>
#include <mscomp/run/component_meshes.h>
#include <mscomp/run/trained_run.h>
#include <mscomp/run/training_run.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace {

mscomp::Config configuration(const std::string& features) {
    return mscomp::parse_config("model: {kind: autoencoder, components: 8}", "train_and_decode",
                                {"data.features=" + std::filesystem::absolute(features).string(),
                                 "data.split={train: every, step: 2}", "train.epochs=40"});
}

void train_and_decode(const std::string& features, const std::string& folder,
                      const std::string& mesh) {
    const mscomp::TrainingResult result = mscomp::train_run(configuration(features), folder);
    std::printf("%s: %d epochs, loss %.3g\n", folder.c_str(), static_cast<int>(result.state.epoch),
                result.state.total);

    mscomp::EvaluationOptions measured;
    measured.run = folder;
    const nlohmann::ordered_json report = mscomp::evaluation_report(measured);
    std::printf("E_rms on %d unseen shapes: %.2f as encoded, %.2f fitted to the vertices\n",
                report["shapes"].get<int>(), report["features"]["rms_error"].get<double>(),
                report["vertices"]["rms_error"].get<double>());

    mscomp::TrainedRun run = mscomp::open_run(folder);
    const std::vector<mscomp::Component> components = run.components();
    const int strongest = mscomp::farthest_first(components).front();
    const mscomp::Synthesis synthesis(*run.model, components);
    const mscomp::ComponentMeshes meshes(run.context(), run.model->rows());
    const std::vector<mscomp::ComponentWeight> whole{{strongest, 1.0}};
    mscomp::write_mesh(mesh, meshes.mesh(synthesis.change(synthesis.codes(whole))));
    std::printf("%s: component %s\n", mesh.c_str(), components[strongest].id.c_str());
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::fprintf(stderr, "usage: train_and_decode FEATURES RUN MESH.obj\n");
        return 2;
    }
    try {
        train_and_decode(argv[1], argv[2], argv[3]);
        return 0;
    } catch (const mscomp::Error& error) {
        std::fprintf(stderr, "train_and_decode: %s\n", error.what());
        return static_cast<int>(error.exit_code());
    }
}
