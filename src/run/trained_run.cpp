// SPDX-License-Identifier: MIT
#include "mscomp/run/trained_run.h"

#include <utility>

#include "make_model.h"
#include "mscomp/acap/edge_weights.h"
#include "mscomp/base/error.h"
#include "mscomp/config/config_file.h"
#include "mscomp/geodesic/heat_geodesics.h"
#include "mscomp/run/run_folder.h"

namespace mscomp {

TrainedRun open_run(const std::string& path, int batch) {
    const std::string file = model_path(path);
    TrainedRun run{ModelFile(file), {}, nullptr, nullptr};
    const ModelContext& context = run.context();
    try {
        run.config = parse_config(context.config, file + " (configuration)");
        parse_edge_weights(context.weights);
    } catch (const Error& error) {
        throw CheckpointError(file, error.what());
    }
    run.distances = std::make_unique<NormalizedGeodesics>(HeatGeodesics(context.reference),
                                                          context.largest_distance);
    try {
        run.model = make_model(run.config, context, *run.distances, ModelUse::reading, batch);
    } catch (const UsageError& error) {
        throw CheckpointError(file, error.what());
    }
    run.file.load(*run.model);
    return run;
}

}  // namespace mscomp
