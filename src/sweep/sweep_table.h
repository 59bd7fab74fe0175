// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mscomp/model/config.h"
#include "sweep_file.h"

namespace mscomp {

/// What became of a point.
struct SweepRow {
    std::string name;
    std::vector<std::string> values;         // of SweepFile::keys
    std::map<std::string, double> measures;  // those that it has, by column
    std::string failure;                     // why it has none; else empty
};

/// Measures that a plot may have along y; those of table.csv without the fit in front.
std::vector<std::string> plotted_measures();

/// The column that has `measure`: features_rms_error where it depends on the fit, else the same.
std::string measure_column(const std::string& measure, const std::string& fit);

/// What a point has for each of the keys that the sweep varies: its own setting as written, else
/// the value of its configuration, empty where its kind has no such key.
std::vector<std::string> varied_values(const SweepFile& sweep, const SweepPoint& point,
                                       const Config& config);

/// Measures of an evaluation_report by column: features_rms_error, ..., kept, kept_0, ...,
/// support_mean_0, ...
std::map<std::string, double> measures_of(const nlohmann::ordered_json& evaluation);

/// Columns are in the same order for the same sweep, without those that no row has.
std::string csv_table(const SweepFile& sweep, const std::vector<SweepRow>& rows);
std::string markdown_table(const SweepFile& sweep, const std::vector<SweepRow>& rows);
nlohmann::ordered_json json_table(const SweepFile& sweep, const std::vector<SweepRow>& rows);

/// The plot that the file asks for: lines where everything along x is a number, bars otherwise.
/// Failed points are left out, and on logarithmic axes numbers <= 0. Throws as line_plot_svg.
std::string plot_of(const SweepFile& sweep, const std::vector<SweepRow>& rows);

}  // namespace mscomp
