// SPDX-License-Identifier: MIT
#include "mscomp/sweep/sweep.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "run/run_lock.h"
#include "sweep_file.h"
#include "sweep_run.h"
#include "sweep_table.h"

namespace mscomp {
namespace {

std::string in_folder(const std::string& folder, const std::string& name) {
    return (std::filesystem::path(folder) / name).string();
}

std::string sweep_lock_path(const std::string& folder) { return in_folder(folder, ".sweep-lock"); }

/// A folder that is new, empty or of an earlier sweep.
void require_sweep_folder(const std::string& folder, bool force) {
    for (const std::string& own : {in_folder(folder, "sweep.yaml"), sweep_lock_path(folder)}) {
        std::error_code error;
        if (std::filesystem::exists(own, error)) return;
    }
    require_free_folder(folder, force);
}

/// The sweep as it was asked for.
std::string record(const SweepFile& sweep, const std::vector<std::string>& overrides) {
    std::string text = fmt::format("# {}\n", sweep.path);
    for (const std::string& set : overrides) text += fmt::format("# --set {}\n", set);
    return text + sweep.text;
}

void write_results(const SweepOptions& options, const SweepFile& sweep,
                   const std::vector<SweepRow>& rows) {
    const std::string csv = in_folder(options.output, "table.csv");
    const std::string markdown = in_folder(options.output, "table.md");
    const std::string plot = in_folder(options.output, "plot.svg");
    OutputFiles files({csv, markdown, plot});
    write_file(files.path(csv), csv_table(sweep, rows));
    write_file(files.path(markdown), markdown_table(sweep, rows));
    write_file(files.path(plot), plot_of(sweep, rows));
    files.commit();
}

/// Trains and measures one point. A number that is not finite is its result, not the end of all.
SweepRow run_point(const SweepOptions& options, const SweepFile& sweep, std::size_t index,
                   const Config& config, const PointData& data) {
    const SweepPoint& point = sweep.points[index];
    const std::string run = in_folder(options.output, point.name);
    SweepRow row{point.name, varied_values(sweep, point, config), {}, ""};
    try {
        train_point(run, config, data, options);
        row.measures = measures_of(evaluate_point(run, sweep.measure, options));
        const TrainingTime time = training_time(run);
        row.measures["epochs"] = static_cast<double>(time.epochs);
        row.measures["training_seconds"] = time.seconds;
    } catch (const NumericalError& error) {
        row.measures.clear();
        row.failure = error.what();
    } catch (const Interrupted&) {
        throw Interrupted(requested_stop(),
                          fmt::format("interrupted in point {} of {}, {}; the same command goes on",
                                      index + 1, sweep.points.size(), point.name));
    }
    return row;
}

}  // namespace

SweepResult run_sweep(const SweepOptions& options, nlohmann::ordered_json& report) {
    const SweepFile sweep = read_sweep(options.sweep);
    std::vector<Config> configs;
    for (const SweepPoint& point : sweep.points) {
        configs.push_back(point_config(sweep, point, options.overrides));
    }
    require_sweep_folder(options.output, options.force);
    RunLock lock(options.output, sweep_lock_path(options.output));
    recover_folder(options.output);
    const std::vector<PointData> data = read_point_data(configs, sweep.measure);

    lock.keep();
    write_file(in_folder(options.output, "sweep.yaml"), record(sweep, options.overrides));
    std::vector<SweepRow> rows;
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
        throw_if_interrupted("interrupted between two points; the same command goes on");
        if (options.on_point) options.on_point(i, sweep.points.size(), sweep.points[i].name);
        rows.push_back(run_point(options, sweep, i, configs[i], data[i]));
        write_results(options, sweep, rows);
    }
    SweepResult result{markdown_table(sweep, rows), {}, rows.size()};
    for (const SweepRow& row : rows) {
        if (!row.failure.empty()) result.failed.push_back(row.name + " (" + row.failure + ")");
    }
    report = {{"sweep", options.sweep},
              {"folder", options.output},
              {"split", sweep.measure.split},
              {"points", json_table(sweep, rows)}};
    return result;
}

}  // namespace mscomp
