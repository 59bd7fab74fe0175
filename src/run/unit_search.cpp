// SPDX-License-Identifier: MIT
#include "mscomp/run/unit_search.h"

#include "mscomp/base/paths.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/kinds/kinds.h"
#include "mscomp/run/trained_run.h"
#include "mscomp/units/units.h"

namespace mscomp {

Config unit_config(const std::string& input) {
    Config config = default_config(units().name);
    if (!is_folder(input) && SafetensorsFile(input).contains("features")) {
        config.data.features = absolute_path(input);
        return config;
    }
    const TrainedRun run = open_run(input);
    config.own<UnitSettings>().rows = run.model->rows();
    config.data.features = run.config.data.features;
    config.data.split = run.config.data.split;
    config.filter.relative_threshold = run.config.filter.relative_threshold;
    config.filter.absolute_threshold = run.config.filter.absolute_threshold;
    config.train.start_run = absolute_path(input);
    return config;
}

}  // namespace mscomp
