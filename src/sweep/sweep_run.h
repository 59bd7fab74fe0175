// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mscomp/model/config.h"
#include "mscomp/sweep/sweep.h"
#include "sweep_file.h"

namespace mscomp {

/// What a run is trained on, known before it is.
struct PointData {
    std::string hash;        // of the feature file
    std::vector<int> train;  // shapes
};

/// Opens every feature file that `configs` name, once, and resolves the splits. Throws what that
/// throws, and UsageError where a split leaves nothing to train on or nothing to measure.
std::vector<PointData> read_point_data(const std::vector<Config>& configs,
                                       const SweepMeasure& measure);

/// Trains the run in the folder `run` as `config` says: not at all if it is finished, further if it
/// was begun with the same configuration and data (train.epochs may have grown), anew otherwise.
/// Throws as train_run, Interrupted.
void train_point(const std::string& run, const Config& config, const PointData& data,
                 const SweepOptions& options);

/// evaluation_report of the run, kept in its evaluation.json with the checkpoint and the measure
/// that it is of; made anew where one of them is another now. Throws as evaluation_report.
nlohmann::ordered_json evaluate_point(const std::string& run, const SweepMeasure& measure,
                                      const SweepOptions& options);

/// Epochs done and the time that their steps took, from metrics.csv.
struct TrainingTime {
    std::int64_t epochs = 0;
    double seconds = 0;
};
TrainingTime training_time(const std::string& run);

}  // namespace mscomp
