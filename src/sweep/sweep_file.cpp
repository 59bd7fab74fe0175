// SPDX-License-Identifier: MIT
#include "sweep_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "config/config_values.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/nearest_name.h"
#include "mscomp/base/path_from.h"
#include "mscomp/config/config_file.h"
#include "mscomp/kinds/kinds.h"
#include "mscomp/run/fits.h"
#include "sweep_points.h"
#include "sweep_table.h"

namespace mscomp {
namespace {

std::string folder_of(const std::string& path) {
    return std::filesystem::path(path).parent_path().string();
}

/// One of `names`. Throws ConfigError with the nearest one.
std::string one_of(const Setting& setting, const std::string& section,
                   const std::vector<std::string>& names) {
    const YAML::Node& node = setting.value;
    if (node.IsScalar() && std::ranges::find(names, node.Scalar()) != names.end()) {
        return node.Scalar();
    }
    std::string message =
        fmt::format("got {}, wanted one of {}", found(node), fmt::join(names, ", "));
    if (node.IsScalar()) {
        message += fmt::format("; the nearest is {}", nearest_name(node.Scalar(), names));
    }
    throw ConfigError(position_of(node, setting.where.path), section + "." + setting.key, message);
}

bool is_true(const Setting& setting, const std::string& section) {
    return one_of(setting, section, {"true", "false"}) == "true";
}

SweepMeasure read_measure(const YAML::Node& node, const std::string& path) {
    SweepMeasure measure;
    for (const Setting& entry : known_entries(node, path, "measure", {"split", "fit"})) {
        if (entry.key == "split") {
            measure.split = one_of(entry, "measure", {"test", "train", "all"});
        } else {
            measure.fit = one_of(entry, "measure", fit_choices());
        }
    }
    return measure;
}

/// Reads what `plot:` says, once points and measure are known.
void read_plot(const YAML::Node& node, SweepFile& sweep) {
    std::vector<std::string> along{"name", "epochs", "training_seconds"};
    along.insert(along.end(), sweep.keys.begin(), sweep.keys.end());
    std::vector<std::string> fits;
    for (const Fit fit : fits_named(sweep.measure.fit)) fits.emplace_back(name_of(fit));
    SweepPlot& plot = sweep.plot;
    for (const Setting& entry : known_entries(
             node, sweep.path, "plot", {"x", "y", "fit", "group", "log_x", "log_y", "title"})) {
        if (entry.key == "x") plot.x = one_of(entry, "plot", along);
        if (entry.key == "y") plot.y = one_of(entry, "plot", plotted_measures());
        if (entry.key == "fit") plot.fit = one_of(entry, "plot", fits);
        if (entry.key == "group") plot.group = one_of(entry, "plot", along);
        if (entry.key == "log_x") plot.log_x = is_true(entry, "plot");
        if (entry.key == "log_y") plot.log_y = is_true(entry, "plot");
        if (entry.key == "title") plot.title = value_text(entry.value);
    }
}

void read_base(const Setting& entry, SweepFile& sweep) {
    if (!sweep.base_path.empty()) {
        throw ConfigError(entry.where, entry.key, "wanted either config or base, got both");
    }
    if (entry.key == "base") {
        sweep.base_path = sweep.path;
        sweep.base = entry.value;
        return;
    }
    if (!entry.value.IsScalar() || entry.value.Scalar().empty()) {
        throw ConfigError(position_of(entry.value, sweep.path), "config",
                          fmt::format("got {}, wanted a file name", found(entry.value)));
    }
    sweep.base_path = path_from(folder_of(sweep.path), entry.value.Scalar());
    const std::string text = read_file(sweep.base_path);
    refuse_other_kinds(text, sweep.base_path);
    sweep.base = load_document(text, sweep.base_path, "YAML");
}

std::vector<std::string> keys_of(const std::vector<SweepPoint>& points) {
    std::vector<std::string> keys;
    for (const SweepPoint& point : points) {
        for (const Setting& setting : point.settings) {
            if (std::ranges::find(keys, setting.key) == keys.end()) keys.push_back(setting.key);
        }
    }
    return keys;
}

void require_free_key(const SweepPoint& point, const std::string& text) {
    const std::string key = text.substr(0, text.find('='));
    if (std::ranges::any_of(point.settings, [&](const Setting& s) { return s.key == key; })) {
        throw ConfigError({"--set " + text}, key,
                          fmt::format("the point {} sets it too; wanted it once", point.name));
    }
}

}  // namespace

SweepFile read_sweep(const std::string& path) {
    SweepFile sweep;
    sweep.path = path;
    sweep.text = read_file(path);
    refuse_other_kinds(sweep.text, path);
    const YAML::Node root = load_document(sweep.text, path, "YAML");
    YAML::Node points, measure, plot;
    for (const Setting& entry :
         known_entries(root, path, "sweep", {"config", "base", "points", "measure", "plot"})) {
        if (entry.key == "config" || entry.key == "base") read_base(entry, sweep);
        if (entry.key == "points") sweep.points = read_points(entry.value, path);
        if (entry.key == "measure") sweep.measure = read_measure(entry.value, path);
        if (entry.key == "plot") plot.reset(entry.value);
    }
    if (sweep.base_path.empty()) {
        throw ConfigError({path}, "config",
                          "missing; wanted config: a file, or base: a configuration");
    }
    if (sweep.points.empty()) {
        throw ConfigError({path}, "points", "missing; wanted grid, list or both");
    }
    sweep.keys = keys_of(sweep.points);
    if (!plot.IsNull()) read_plot(plot, sweep);
    if (sweep.plot.fit.empty()) {
        sweep.plot.fit = name_of(fits_named(sweep.measure.fit).back());
    }
    if (sweep.plot.title.empty()) sweep.plot.title = std::filesystem::path(path).stem().string();
    return sweep;
}

Config point_config(const SweepFile& sweep, const SweepPoint& point,
                    const std::vector<std::string>& overrides) {
    std::string kind = kind_in(sweep.base, overrides);
    for (const Setting& setting : point.settings) kind = kind_in(setting).value_or(kind);
    Config config = default_config(kind);
    ConfigReader reader(config);
    reader.read_document(sweep.base, sweep.base_path);
    // Names that are absolute already are left as they are by the next of these.
    anchor_paths(config, folder_of(sweep.base_path));
    for (const std::string& text : overrides) {
        require_free_key(point, text);
        reader.read_override(text);
    }
    anchor_paths(config, "");
    for (const Setting& setting : point.settings) reader.read_setting(setting);
    anchor_paths(config, folder_of(sweep.path));
    reader.check(sweep.base_path);
    return config;
}

}  // namespace mscomp
