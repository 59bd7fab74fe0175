// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "config/config_reader.h"
#include "mscomp/model/config.h"

namespace mscomp {

/// One training of a sweep: what it changes of the base configuration.
struct SweepPoint {
    std::string name;  // of its folder
    FilePosition where;
    std::vector<Setting> settings;  // in the order in which they are applied
};

struct SweepMeasure {
    std::string split = "test";  // all | train | test
    std::string fit = "both";    // a choice of fits.h
};

struct SweepPlot {
    std::string x = "name";  // a key that the points set, or a column of the table
    std::string y = "rms_error";
    std::string fit;    // one of these; empty: vertices where they are measured, else the last
    std::string group;  // a key likewise: a line for each of its values; empty: one line
    bool log_x = false, log_y = false;
    std::string title;  // empty: the name of the file
};

/// A sweep as its file describes it (docs/sweep.md).
struct SweepFile {
    std::string path, text;
    std::string base_path;  // of the base configuration: another file, or this one
    YAML::Node base;
    std::vector<SweepPoint> points;
    std::vector<std::string> keys;  // that any point sets, in the order of their first use
    SweepMeasure measure;
    SweepPlot plot;
};

/// Strict as read_config: unknown or repeated keys, other types and points whose folders would have
/// the same name throw ConfigError with file, line and column. Throws IoError. What points set is
/// checked by point_config.
SweepFile read_sweep(const std::string& path);

/// The configuration of a point: base, then `overrides` ("train.epochs=100"), then its settings.
/// File names in it are absolute: counted from the file that names them, those of `overrides` from
/// the current folder. Throws ConfigError, also for an override of what the point sets.
Config point_config(const SweepFile& sweep, const SweepPoint& point,
                    const std::vector<std::string>& overrides);

}  // namespace mscomp
