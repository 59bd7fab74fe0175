// SPDX-License-Identifier: MIT
#include "sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <utility>

#include "mscomp/base/parsed_number.h"
#include "mscomp/config/config_file.h"
#include "mscomp/run/fits.h"
#include "sweep_points.h"

namespace mscomp {
namespace {

constexpr int kMostLevels = 8;
constexpr std::array<std::string_view, 5> kFitted{"rms_error", "relative_squared_error_mean",
                                                  "relative_squared_error_max", "sted",
                                                  "mean_vertex_distance"};

std::string of_level(const char* name, std::size_t level) {
    return fmt::format("{}_{}", name, level);
}

/// Measures in the order of the columns.
std::vector<std::string> measure_columns() {
    std::vector<std::string> columns;
    for (const std::string_view name : kFitted) {
        for (const std::string& fit : fit_names())
            columns.push_back(fmt::format("{}_{}", fit, name));
    }
    columns.emplace_back("kept");
    for (const char* name : {"kept", "support_mean"}) {
        for (std::size_t l = 0; l < kMostLevels; ++l) columns.push_back(of_level(name, l));
    }
    columns.emplace_back("epochs");
    columns.emplace_back("training_seconds");
    return columns;
}

/// A short table leaves out what table.csv has besides.
enum class Length { full, brief };

bool is_secondary(const std::string& column) {
    return column.ends_with("relative_squared_error_mean") || column.ends_with("_vertex_distance");
}

std::vector<std::string> present_columns(const std::vector<SweepRow>& rows, Length length) {
    std::vector<std::string> columns = measure_columns();
    std::erase_if(columns, [&](const std::string& column) {
        if (length == Length::brief && is_secondary(column)) return true;
        return std::ranges::none_of(
            rows, [&](const SweepRow& row) { return row.measures.contains(column); });
    });
    return columns;
}

using Cells = std::vector<std::string>;

/// The table row by row, the names of its columns first.
std::vector<Cells> cells_of(const SweepFile& sweep, const std::vector<SweepRow>& rows,
                            Length length) {
    const int digits = length == Length::brief ? 4 : 9;
    const std::vector<std::string> columns = present_columns(rows, length);
    const bool any_failed =
        std::ranges::any_of(rows, [](const SweepRow& row) { return !row.failure.empty(); });
    Cells names{"name"};
    names.insert(names.end(), sweep.keys.begin(), sweep.keys.end());
    names.insert(names.end(), columns.begin(), columns.end());
    if (any_failed) names.emplace_back("failure");
    std::vector<Cells> all{names};
    for (const SweepRow& row : rows) {
        Cells cells{row.name};
        cells.insert(cells.end(), row.values.begin(), row.values.end());
        for (const std::string& column : columns) {
            const auto measure = row.measures.find(column);
            const bool is_there = measure != row.measures.end();
            cells.push_back(is_there ? fmt::format("{:.{}g}", measure->second, digits) : "");
        }
        if (any_failed) cells.push_back(row.failure);
        all.push_back(std::move(cells));
    }
    return all;
}

using Quote = std::function<std::string(const std::string&)>;

std::string csv_quoted(const std::string& cell) {
    if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
    std::string text = "\"";
    for (const char c : cell) text += c == '"' ? std::string("\"\"") : std::string(1, c);
    return text + "\"";
}

std::string markdown_quoted(const std::string& cell) {
    std::string text;
    for (const char c : cell) {
        if (c == '|') text += '\\';
        text += c == '\n' ? ' ' : c;
    }
    return text;
}

std::string joined(const Cells& cells, const char* between, const Quote& quote) {
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (i > 0) line += between;
        line += quote(cells[i]);
    }
    return line;
}

/// "model.levels[0].components" of a configuration read back; empty where it has no such key.
std::string value_in(const YAML::Node& whole, const std::string& key) {
    YAML::Node node = YAML::Clone(whole);
    std::string rest = key;
    while (!rest.empty()) {
        const std::size_t end = rest.find_first_of(".[");
        std::string name = rest.substr(0, end);
        rest = end == std::string::npos ? "" : rest.substr(end + 1);
        if (name.empty()) continue;  // behind "]."
        const bool is_index = name.back() == ']';
        if (is_index) name.pop_back();
        const auto index = is_index ? parsed_number<std::size_t>(name) : std::nullopt;
        if (is_index ? !index || !node.IsSequence() : !node.IsMap()) return "";
        const YAML::Node next = index ? node[*index] : node[name];
        if (!next) return "";
        node.reset(next);
    }
    return value_text(node);
}

void add_if_number(std::map<std::string, double>& measures, const std::string& column,
                   const nlohmann::ordered_json& parent, const std::string& key) {
    if (parent.is_object() && parent.contains(key) && parent[key].is_number()) {
        measures[column] = parent[key].get<double>();
    }
}

/// How many components are kept and the mean share of the vertices that these act on, by level.
void add_components(std::map<std::string, double>& measures, const nlohmann::ordered_json& list) {
    measures["kept"] = 0;
    for (const auto& component : list) {
        const auto level = component.at("level").get<std::size_t>();
        double& kept = measures[of_level("kept", level)];
        if (!component.at("kept").get<bool>()) continue;
        double& support = measures[of_level("support_mean", level)];
        support += (component.at("support").get<double>() - support) / ++kept;
        ++measures["kept"];
    }
}

}  // namespace

std::string measure_column(const std::string& measure, const std::string& fit) {
    const bool is_fitted = std::ranges::find(kFitted, measure) != kFitted.end();
    return is_fitted ? fit + "_" + measure : measure;
}

std::vector<std::string> plotted_measures() {
    std::vector<std::string> names(kFitted.begin(), kFitted.end());
    for (const std::string& column : measure_columns()) {
        const bool is_fitted = std::ranges::any_of(
            fit_names(), [&](const std::string& fit) { return column.starts_with(fit + "_"); });
        if (!is_fitted) names.push_back(column);
    }
    return names;
}

std::vector<std::string> varied_values(const SweepFile& sweep, const SweepPoint& point,
                                       const Config& config) {
    const YAML::Node whole = load_document(write_config(config, false), point.name, "YAML");
    std::vector<std::string> values;
    for (const std::string& key : sweep.keys) {
        const auto own = std::ranges::find(point.settings, key, &Setting::key);
        values.push_back(own != point.settings.end() ? value_text(own->value)
                                                     : value_in(whole, key));
    }
    return values;
}

std::map<std::string, double> measures_of(const nlohmann::ordered_json& evaluation) {
    std::map<std::string, double> measures;
    for (const std::string& fit : fit_names()) {
        if (!evaluation.contains(fit)) continue;
        for (const std::string_view name : kFitted) {
            add_if_number(measures, fmt::format("{}_{}", fit, name), evaluation[fit],
                          std::string(name));
        }
    }
    if (evaluation.contains("component_list")) {
        add_components(measures, evaluation["component_list"]);
    }
    return measures;
}

std::string csv_table(const SweepFile& sweep, const std::vector<SweepRow>& rows) {
    std::string text;
    for (const Cells& cells : cells_of(sweep, rows, Length::full)) {
        text += joined(cells, ",", csv_quoted) + "\n";
    }
    return text;
}

std::string markdown_table(const SweepFile& sweep, const std::vector<SweepRow>& rows) {
    std::string text;
    for (const Cells& cells : cells_of(sweep, rows, Length::brief)) {
        const bool is_first = text.empty();
        text += "| " + joined(cells, " | ", markdown_quoted) + " |\n";
        if (!is_first) continue;
        for (std::size_t i = 0; i < cells.size(); ++i) text += "|---";
        text += "|\n";
    }
    return text;
}

nlohmann::ordered_json json_table(const SweepFile& sweep, const std::vector<SweepRow>& rows) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const SweepRow& row : rows) {
        nlohmann::ordered_json settings = nlohmann::ordered_json::object();
        for (std::size_t k = 0; k < sweep.keys.size(); ++k) settings[sweep.keys[k]] = row.values[k];
        nlohmann::ordered_json point{{"name", row.name}, {"settings", settings}};
        for (const std::string& column : measure_columns()) {
            const auto measure = row.measures.find(column);
            if (measure == row.measures.end()) continue;
            const double value = measure->second;
            if (column.starts_with("kept") || column == "epochs") {
                point[column] = static_cast<std::int64_t>(value);
            } else {
                point[column] = value;
            }
        }
        point["failure"] =
            row.failure.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(row.failure);
        points.push_back(std::move(point));
    }
    return points;
}

}  // namespace mscomp
