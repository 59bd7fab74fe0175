// SPDX-License-Identifier: MIT
#include "mscomp/run/refinement.h"

#include "mscomp/base/paths.h"
#include "mscomp/kinds/kinds.h"
#include "mscomp/multiscale/multiscale.h"
#include "mscomp/run/trained_run.h"
#include "starting_run.h"

namespace mscomp {
namespace {

/// As many global components as there are: a training may have chosen none.
MultiscaleSettings with_globals_of(const LearnedModel& model, MultiscaleSettings settings) {
    const std::vector<LevelSize> levels = model.levels();
    const bool has_globals = levels.size() > settings.levels.size();
    settings.global_components = has_globals ? levels.front().codes() : 0;
    return settings;
}

MultiscaleSettings settings_for(TrainedRun& run) {
    if (const auto* own = std::any_cast<MultiscaleSettings>(&run.config.settings)) {
        return with_globals_of(*run.model, *own);
    }
    MultiscaleSettings settings;
    settings.global_components = 0;
    settings.levels = levels_around(given_components(*run.model, run.file.codes()), *run.distances);
    return settings;
}

}  // namespace

Config refined_config(const std::string& path) {
    constexpr int kEpochs = 4;
    TrainedRun run = open_run(path);
    require_rows(run, ShapeRows::features);
    MultiscaleSettings settings = settings_for(run);
    settings.rounds = 0;
    settings.select = false;
    Config config = default_config(multiscale().name);
    config.settings = settings;
    config.data = run.config.data;
    config.data.center = Scaling::reference;
    if (run.config.kind != config.kind) config.data.metric = FeatureMetric::area;
    config.train.epochs = kEpochs;
    config.train.start_run = absolute_path(path);
    config.train.seed = run.config.train.seed;
    config.train.fill_up_to = run.config.train.fill_up_to;
    config.filter = run.config.filter;
    return config;
}

}  // namespace mscomp
