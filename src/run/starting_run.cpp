// SPDX-License-Identifier: MIT
#include "starting_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "mscomp/base/error.h"
#include "mscomp/base/paths.h"
#include "mscomp/run/run_folder.h"

namespace mscomp {
namespace {

void require_same_features(const TrainedRun& run, const ModelContext& context) {
    const ModelContext& own = run.context();
    const std::string& path = run.file.path();
    if (own.mesh().vertices != context.mesh().vertices ||
        own.mesh().faces != context.mesh().faces) {
        throw UsageError(
            fmt::format("{} has another reference than {}; wanted components of the "
                        "same mesh",
                        path, context.source));
    }
    if (own.source_hash != context.source_hash || own.weights != context.weights) {
        throw UsageError(
            fmt::format("{} was trained on other features than {} holds; wanted "
                        "components of the same",
                        path, context.source));
    }
    if (std::ranges::includes(context.train_shapes, own.train_shapes)) return;
    throw UsageError(fmt::format(
        "{} has learnt from shapes that data.split leaves to test; wanted all of them to train",
        path));
}

}  // namespace

void require_rows(const TrainedRun& run, ShapeRows rows) {
    if (run.model->rows() == rows) return;
    const auto name = [](ShapeRows of) {
        return of == ShapeRows::features ? "features" : "positions";
    };
    throw UsageError(
        fmt::format("{} is of kind {}, whose components are changes of {}; wanted "
                    "changes of {}",
                    run.file.path(), run.config.kind, name(run.model->rows()), name(rows)));
}

StartingRun starting_run(const std::string& path, ShapeRows rows, const ModelContext& context) {
    const TrainedRun run = open_run(path);
    require_rows(run, rows);
    require_same_features(run, context);
    StartingRun start{given_components(*run.model, run.file.codes()), run.file.data_hash(), {}};
    start.note = fmt::format(
        "begins with the {} components of {} (kind {}, epoch {}, XXH3 of its data {})",
        start.components.count(), path, run.config.kind, run.file.state().epoch, start.hash);
    return start;
}

bool is_start(const std::string& path, const std::string& hash) {
    if (path.empty() || !path_exists(model_path(path))) return true;
    return ModelFile(model_path(path)).data_hash() == hash;
}

}  // namespace mscomp
