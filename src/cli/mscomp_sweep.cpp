// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp_commands.h"
#include "sweep_file.h"
#include "sweep_run.h"
#include "sweep_table.h"

namespace mscomp {
namespace {

std::string in_folder(const std::string& folder, const std::string& name) {
    return (std::filesystem::path(folder) / name).string();
}

/// A folder that is new, empty or of an earlier sweep.
void require_sweep_folder(const std::string& folder, bool force) {
    if (std::filesystem::exists(in_folder(folder, "sweep.yaml"))) return;
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
    write_file(in_folder(options.output, "table.csv"), csv_table(sweep, rows));
    write_file(in_folder(options.output, "table.md"), markdown_table(sweep, rows));
    write_file(in_folder(options.output, "plot.svg"), plot_of(sweep, rows));
}

/// Trains and measures one point. A number that is not finite is its result, not the end of all.
SweepRow run_point(const SweepOptions& options, const SweepFile& sweep, std::size_t index,
                   const nn::Config& config, const PointData& data) {
    const SweepPoint& point = sweep.points[index];
    const std::string run = in_folder(options.output, point.name);
    CommonOptions common = options.common;
    common.json = false;
    SweepRow row{point.name, varied_values(sweep, point, config), {}, ""};
    try {
        train_point(run, config, data, common);
        row.measures = measures_of(evaluate_point(run, sweep.measure, common));
        const TrainingTime time = training_time(run);
        row.measures["epochs"] = static_cast<double>(time.epochs);
        row.measures["training_seconds"] = time.seconds;
    } catch (const NumericalError& error) {
        row.measures.clear();
        row.failure = error.what();
    } catch (const Interrupted&) {
        throw Interrupted(interrupt_signal(),
                          fmt::format("interrupted in point {} of {}, {}; the same command goes on",
                                      index + 1, sweep.points.size(), point.name));
    }
    return row;
}

void announce(const SweepOptions& options, const SweepFile& sweep, std::size_t index) {
    if (options.common.quiet) return;
    fmt::print(stderr, "sweep: point {} of {}: {}\n", index + 1, sweep.points.size(),
               sweep.points[index].name);
    std::fflush(stderr);
}

void print_results(const SweepOptions& options, const SweepFile& sweep,
                   const std::vector<SweepRow>& rows) {
    if (!options.common.json) {
        fmt::print("{}", markdown_table(sweep, rows));
        return;
    }
    const nlohmann::ordered_json report{{"sweep", options.sweep},
                                        {"folder", options.output},
                                        {"split", sweep.measure.split},
                                        {"points", json_table(sweep, rows)}};
    fmt::print("{}\n", report.dump(2));
}

void require_no_failure(const std::vector<SweepRow>& rows) {
    std::vector<std::string> failed;
    for (const SweepRow& row : rows) {
        if (!row.failure.empty()) failed.push_back(row.name + " (" + row.failure + ")");
    }
    if (failed.empty()) return;
    throw NumericalError(fmt::format("{} of {} points failed, the others are done: {}",
                                     failed.size(), rows.size(), fmt::join(failed, ", ")));
}

}  // namespace

void setup_sweep(CLI::App& app) {
    const auto options = std::make_shared<SweepOptions>();
    CLI::App* command =
        app.add_subcommand("sweep", "Train and measure many variants of a configuration");
    command->add_option("SWEEP", options->sweep, "YAML file of base, points, measure and plot")
        ->required();
    command
        ->add_option("-o,--output", options->output,
                     "Folder of runs and results; an earlier one of the sweep goes on")
        ->required();
    command
        ->add_option("--set", options->overrides,
                     "key=value for all points, e.g. data.features=F; repeatable")
        ->allow_extra_args(false);
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command,
                "mscomp sweep data/ablations/levels.yaml --set data.features=arm.safetensors "
                "--set 'data.split={train: every, step: 2}' -o levels");
    command->callback([options] { run_sweep(*options); });
}

void run_sweep(const SweepOptions& options) {
    const SweepFile sweep = read_sweep(options.sweep);
    std::vector<nn::Config> configs;
    for (const SweepPoint& point : sweep.points) {
        configs.push_back(point_config(sweep, point, options.overrides));
    }
    require_sweep_folder(options.output, options.common.force);
    const std::vector<PointData> data = read_point_data(configs, sweep.measure);

    create_folder(options.output);
    write_file(in_folder(options.output, "sweep.yaml"), record(sweep, options.overrides));
    std::vector<SweepRow> rows;
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
        throw_if_interrupted("interrupted between two points; the same command goes on");
        announce(options, sweep, i);
        rows.push_back(run_point(options, sweep, i, configs[i], data[i]));
        write_results(options, sweep, rows);
    }
    print_results(options, sweep, rows);
    require_no_failure(rows);
}

}  // namespace mscomp
