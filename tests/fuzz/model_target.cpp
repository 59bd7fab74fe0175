// SPDX-License-Identifier: MIT
#include <cmath>

#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/base/error.h"
#include "mscomp/run/trained_run.h"

namespace mscomp::fuzz {
namespace {

void check_sound(const ModelFile& file) {
    const ModelContext& context = file.context();
    const int vertices = context.reference.vertex_count();
    require(vertices > 0 && context.reference.face_count() > 0, "there are vertices and faces");
    for (const Point& point : context.reference.vertices) {
        for (const double x : point) require(std::isfinite(x), "the reference is finite");
    }
    for (const Face& face : context.reference.faces) {
        for (const int v : face) require(v >= 0 && v < vertices, "faces refer to vertices");
    }
    require(file.state().epoch >= 0 && file.state().step >= 0, "training goes forward");
    // How many codes a shape has is known once the model is made.
    require(file.codes().code_count == 0 ||
                file.codes().shape_count() == static_cast<int>(context.train_shapes.size()),
            "every training shape has codes");
    for (const float code : file.codes().values) require(std::isfinite(code), "codes are finite");
}

/// As the commands that use a model do, which say so where numbers are beyond float32.
void check_components(TrainedRun& run) {
    const auto vertices = static_cast<std::size_t>(run.model->vertex_count());
    const auto width = static_cast<std::size_t>(row_width(run.model->rows()));
    const std::vector<float> rows = run.model->decode(run.model->reference_codes());
    require(rows.size() == vertices * width, "every vertex has a row");
    const std::vector<Component> components = run.components();
    require(static_cast<int>(components.size()) == run.model->code_count(),
            "every code has a component");
    for (const Component& component : components) {
        for (const int v : {component.center, component.longest}) {
            require(v >= 0 && v < run.model->vertex_count(), "components lie at vertices");
        }
    }
}

}  // namespace

void check_model(std::span<const std::byte> input) {
    static const MemoryFile memory;
    const std::string path = memory.filled_with(input);
    const auto file = unless_refused<CheckpointError>(path, [&] { return ModelFile(path); });
    if (file) check_sound(*file);
    auto run = unless_refused<CheckpointError>(path, [&] { return open_run(path); });
    require(file || !run, "a run is refused if its file is");
    if (run) check_components(*run);
}

}  // namespace mscomp::fuzz
