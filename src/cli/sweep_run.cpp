// SPDX-License-Identifier: MIT
#include "sweep_run.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>
#include <utility>

#include "evaluation.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/cli/config_file.h"
#include "mscomp/cli/split.h"
#include "mscomp/nn/model_file.h"
#include "trained_run.h"

namespace mscomp {
namespace {

/// What of a configuration decides the result after a given number of epochs.
std::string decisive(nn::Config config) {
    config.train.epochs = 1;
    config.train.checkpoint_every = 1;
    return write_config(config, false);
}

enum class Progressed { not_at_all, partly, to_the_end };

bool has_config(const nn::ModelFile& file, const nn::Config& config, const std::string& path) {
    try {
        return decisive(parse_config(file.context().config, path)) == decisive(config);
    } catch (const ConfigError&) {
        return false;  // of a version that had other keys
    }
}

/// How far what lies in `run` is on the way to `config`.
Progressed progress_of(const std::string& run, const nn::Config& config, const PointData& data) {
    const std::string path = checkpoint_path(run);
    if (!std::filesystem::exists(path)) return Progressed::not_at_all;
    const nn::ModelFile file(path);
    const bool is_same = has_config(file, config, path) &&
                         file.context().source_hash == data.hash &&
                         file.context().train_shapes == data.train;
    if (!is_same || file.state().epoch > config.train.epochs) return Progressed::not_at_all;
    const bool is_over = file.state().is_plateau || file.state().epoch == config.train.epochs;
    return is_over ? Progressed::to_the_end : Progressed::partly;
}

std::string evaluation_path(const std::string& run) {
    return (std::filesystem::path(run) / "evaluation.json").string();
}

/// What an evaluation depends on.
nlohmann::ordered_json origin(const std::string& run, const SweepMeasure& measure) {
    const SafetensorsFile file(checkpoint_path(run));
    const auto hash = [&](const char* key) { return file.metadata().at(key); };
    return {{"checkpoint", hash("xxh3")},
            {"checkpoint_header", hash("xxh3_header")},
            {"split", measure.split},
            {"fit", measure.fit}};
}

}  // namespace

std::vector<PointData> read_point_data(const std::vector<nn::Config>& configs,
                                       const SweepMeasure& measure) {
    std::map<std::string, std::pair<std::string, int>> files;  // hash, shapes
    std::vector<PointData> all;
    for (const nn::Config& config : configs) {
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

void train_point(const std::string& run, const nn::Config& config, const PointData& data,
                 const CommonOptions& common) {
    const Progressed progressed = progress_of(run, config, data);
    if (progressed == Progressed::to_the_end) return;
    write_file(config_path(run), write_config(config, true));
    TrainOptions options;
    options.config = config_path(run);
    options.output = run;
    options.resume = progressed == Progressed::partly;
    options.report = false;
    options.common = common;
    options.common.force = true;  // what the folder has is of an earlier state of this point
    run_train(options);
}

nlohmann::ordered_json evaluate_point(const std::string& run, const SweepMeasure& measure,
                                      const CommonOptions& common) {
    const nlohmann::ordered_json made_from = origin(run, measure);
    const std::string path = evaluation_path(run);
    if (std::filesystem::exists(path)) {
        const auto kept = nlohmann::ordered_json::parse(read_file(path), nullptr, false);
        if (kept.is_object() && kept.contains("made_from") && kept.contains("evaluation") &&
            kept["made_from"] == made_from) {
            return kept["evaluation"];
        }
    }
    EvaluateOptions options;
    options.run = run;
    options.split = measure.split;
    options.fit = measure.fit;
    options.common = common;
    const nlohmann::ordered_json evaluation = evaluation_report(options);
    const nlohmann::ordered_json file{{"made_from", made_from}, {"evaluation", evaluation}};
    write_file(path, file.dump(2) + "\n");
    // What was written has null where the number is not finite: the same from now on.
    return nlohmann::ordered_json::parse(evaluation.dump());
}

TrainingTime training_time(const std::string& run) {
    std::istringstream lines(read_file(metrics_path(run)));
    std::string line;
    std::getline(lines, line);
    TrainingTime time;
    std::int64_t steps = 0;
    while (std::getline(lines, line)) {
        const std::int64_t step = std::stoll(line.substr(line.find(',') + 1));
        time.epochs = std::stoll(line);
        time.seconds +=
            static_cast<double>(step - steps) * std::stod(line.substr(line.rfind(',') + 1)) / 1000;
        steps = step;
    }
    return time;
}

}  // namespace mscomp
