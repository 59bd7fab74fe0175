// SPDX-License-Identifier: MIT
#include "sweep_run.h"

#include <fmt/format.h>

#include <optional>
#include <sstream>
#include <utility>

#include "kept_evaluation.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/paths.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/report/evaluation.h"
#include "mscomp/run/metrics_row.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/split.h"
#include "mscomp/run/training_run.h"
#include "sweep_table.h"

namespace mscomp {
namespace {

/// What an evaluation depends on.
nlohmann::ordered_json origin(const std::string& run, const SweepMeasure& measure) {
    const SafetensorsFile file(checkpoint_path(run));
    const auto hash = [&](const char* key) {
        const auto found = file.metadata().find(key);
        if (found != file.metadata().end()) return found->second;
        throw CheckpointError(file.path(), "has no checksum, wanted a checkpoint as it was saved");
    };
    return {{"checkpoint", hash("xxh3")},
            {"checkpoint_header", hash("xxh3_header")},
            {"split", measure.split},
            {"fit", measure.fit}};
}

}  // namespace

std::vector<PointData> read_point_data(const std::vector<Config>& configs,
                                       const SweepMeasure& measure) {
    std::map<std::string, std::pair<std::string, int>> files;  // hash, shapes
    std::vector<PointData> all;
    for (const Config& config : configs) {
        const std::string& path = config.data.features;
        if (!files.contains(path)) {
            const FeatureFile file(path);
            files[path] = {file.data_hash(), file.shape_count()};
        }
        const auto& [hash, shapes] = files.at(path);
        Split split = resolve_split(config.data.split, shapes, "");
        if (split.train.empty()) throw UsageError("data.split leaves no shape to train on");
        if (split.test.empty() && measure.split == "test") {
            throw UsageError(
                fmt::format("{}: all {} shapes train; wanted a data.split that leaves "
                            "some, or measure: {{split: train}}",
                            path, shapes));
        }
        all.push_back({hash, std::move(split.train)});
    }
    return all;
}

void train_point(const std::string& run, const Config& config, const PointData& data,
                 const SweepOptions& options) {
    const TrainingProgress progress = training_progress(run, {config, data.hash, data.train});
    if (progress == TrainingProgress::finished) return;
    TrainingOptions training;
    training.resume = progress == TrainingProgress::begun;
    training.title = fmt::format("mscomp sweep {}", options.sweep);
    if (options.on_training) {
        training.on_begin = [&](const TrainingState& state) {
            options.on_training(state, config.train.epochs);
        };
    }
    training.on_epoch = options.on_epoch;
    if (options.on_setback) {
        training.on_setback = [&](const TrainingState& state, const std::string& what) {
            options.on_setback(state, config.train.epochs, what);
        };
    }
    training.should_stop = interrupted;
    training.should_save = take_save_request;
    if (train_run(config, run, training).is_stopped) throw_if_interrupted("interrupted");
}

nlohmann::ordered_json evaluate_point(const std::string& run, const SweepMeasure& measure,
                                      const SweepOptions& options) {
    const nlohmann::ordered_json made_from = origin(run, measure);
    const std::string path = evaluation_path(run);
    if (auto kept = kept_evaluation(path, made_from)) return std::move(*kept);
    EvaluationOptions evaluated;
    evaluated.run = run;
    evaluated.split = measure.split;
    evaluated.fit = measure.fit;
    evaluated.on_progress = options.on_measure;
    return keep_evaluation(path, made_from, evaluation_report(evaluated));
}

TrainingTime training_time(const std::string& run) {
    std::istringstream lines(read_file(metrics_path(run)));
    std::string line;
    std::getline(lines, line);
    TrainingTime time;
    MetricsRow before;
    for (std::int64_t n = 2; std::getline(lines, line); ++n) {
        const MetricsRow row = metrics_row(line, before, {metrics_path(run), n});
        time.epochs = row.epoch;
        time.seconds += static_cast<double>(row.step - before.step) * row.step_ms / 1000;
        before = row;
    }
    return time;
}

}  // namespace mscomp
