// SPDX-License-Identifier: MIT
#include "sweep_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>

#include "config/config_values.h"
#include "mscomp/base/nearest_name.h"

namespace mscomp {
namespace {

constexpr std::size_t kLongestValue = 40;
constexpr std::size_t kLongestName = 120;
constexpr std::size_t kMostPoints = 2'000;
constexpr std::size_t kMostSettings = 20'000;

bool is_plain(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '+' || c == '-';
}

/// FNV-1a: names have to stay the same from version to version.
std::string short_hash(std::string_view text) {
    std::uint32_t hash = 2166136261U;
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
    return fmt::format("{:08x}", hash);
}

/// As a part of a folder name; where something had to go, a hash keeps different texts apart.
std::string safe_text(const std::string& text, std::size_t longest) {
    std::string safe;
    for (const char c : text) {
        if (is_plain(c)) {
            safe += c;
        } else if (!safe.empty() && safe.back() != '-') {
            safe += '-';
        }
    }
    if (safe == text && safe.size() <= longest) return safe;
    safe.resize(std::min(safe.size(), longest));
    return safe + "-" + short_hash(text);
}

/// "model.levels[0].components" -> "levels0.components".
std::string short_key(const std::string& key) {
    std::string result;
    for (const char c : key.substr(key.find('.') + 1)) {
        const bool is_hiding = c == '.' && result.empty();
        if ((is_plain(c) || c == '_') && !is_hiding) result += c;
    }
    return result;
}

std::string derived_name(const std::vector<Setting>& settings) {
    std::string name;
    for (const Setting& setting : settings) {
        if (!name.empty()) name += '_';
        name += short_key(setting.key) + "=" + safe_text(value_text(setting.value), kLongestValue);
    }
    if (name.size() <= kLongestName) return name;
    return name.substr(0, kLongestName) + "-" + short_hash(name);
}

/// A name given by the user, as it is.
std::string given_name(const YAML::Node& node, const std::string& path, const std::string& dotted) {
    constexpr const char* kWanted =
        "letters, digits, . _ + - = and no . in front, at most 120, and no file of the sweep";
    constexpr std::array<std::string_view, 4> kFiles{"sweep.yaml", "table.csv", "table.md",
                                                     "plot.svg"};
    const bool is_name =
        node.IsScalar() && !node.Scalar().empty() && node.Scalar().size() <= kLongestName &&
        node.Scalar().front() != '.' && std::ranges::find(kFiles, node.Scalar()) == kFiles.end() &&
        std::ranges::all_of(node.Scalar(),
                            [](char c) { return is_plain(c) || c == '_' || c == '='; });
    if (!is_name) {
        throw ConfigError(position_of(node, path), dotted,
                          fmt::format("got {}, wanted {}", found(node), kWanted));
    }
    return node.Scalar();
}

std::vector<Setting> read_settings(const YAML::Node& node, const std::string& path,
                                   const std::string& dotted) {
    if (!node.IsMap() || node.size() == 0) {
        throw ConfigError(position_of(node, path), dotted,
                          fmt::format("got {}, wanted keys of the configuration, such as "
                                      "train.epochs, and their values",
                                      found(node)));
    }
    std::vector<Setting> settings;
    std::set<std::string> names;
    for (const auto& entry : node) {
        const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : found(entry.first);
        const FilePosition where = position_of(entry.first, path);
        if (!names.insert(name).second) {
            throw ConfigError(where, fmt::format("{}.{}", dotted, name),
                              "given twice; wanted once");
        }
        settings.push_back({name, where, entry.second});
    }
    return settings;
}

/// Throws ConfigError where `points` of `keys` each are more than anybody trains. (Their product is
/// no overflow: no document has more than 100,000 values.)
void require_few(std::size_t points, std::size_t keys, const FilePosition& where) {
    if (points > kMostPoints) {
        throw ConfigError(where, "points",
                          fmt::format("{} points, wanted at most {}", points, kMostPoints));
    }
    if (points * keys > kMostSettings) {
        throw ConfigError(where, "points",
                          fmt::format("{} points of {} keys each, wanted at most {} values in all",
                                      points, keys, kMostSettings));
    }
}

/// Cartesian product, the last key fastest.
std::vector<SweepPoint> grid_points(const YAML::Node& node, const std::string& path) {
    std::vector<SweepPoint> points(1);
    const std::vector<Setting> axes = read_settings(node, path, "points.grid");
    for (const Setting& axis : axes) {
        if (!axis.value.IsSequence() || axis.value.size() == 0) {
            throw ConfigError(position_of(axis.value, path), "points.grid." + axis.key,
                              fmt::format("got {}, wanted a list of values", found(axis.value)));
        }
        require_few(points.size() * axis.value.size(), axes.size(), axis.where);
        std::vector<SweepPoint> longer;
        for (const SweepPoint& point : points) {
            for (const YAML::Node& value : axis.value) {
                longer.push_back(point);
                longer.back().where = position_of(value, path);
                longer.back().settings.push_back({axis.key, axis.where, value});
            }
        }
        points = std::move(longer);
    }
    for (SweepPoint& point : points) point.name = derived_name(point.settings);
    return points;
}

SweepPoint listed_point(const YAML::Node& node, const std::string& path,
                        const std::string& dotted) {
    SweepPoint point{"", position_of(node, path), {}};
    for (const Setting& entry : known_entries(node, path, dotted, {"name", "set"})) {
        if (entry.key == "name") point.name = given_name(entry.value, path, dotted + ".name");
        // `set: {}` is the base as it is.
        const bool is_base = entry.value.IsMap() && entry.value.size() == 0;
        if (entry.key == "set" && !is_base) {
            point.settings = read_settings(entry.value, path, dotted + ".set");
        }
    }
    if (point.name.empty()) point.name = derived_name(point.settings);
    if (point.name.empty()) {
        throw ConfigError(point.where, dotted, "wanted a name, or something to set");
    }
    return point;
}

std::vector<SweepPoint> list_points(const YAML::Node& node, const std::string& path) {
    if (!node.IsSequence() || node.size() == 0) {
        throw ConfigError(
            position_of(node, path), "points.list",
            fmt::format("got {}, wanted a list of points {{name, set}}", found(node)));
    }
    std::vector<SweepPoint> points;
    for (std::size_t i = 0; i < node.size(); ++i) {
        points.push_back(listed_point(node[i], path, fmt::format("points.list[{}]", i)));
    }
    return points;
}

SweepPoint joined(const SweepPoint& listed, const SweepPoint& on_grid) {
    SweepPoint point{listed.name + "_" + on_grid.name, listed.where, listed.settings};
    for (const Setting& setting : on_grid.settings) {
        if (std::ranges::any_of(listed.settings,
                                [&](const Setting& s) { return s.key == setting.key; })) {
            throw ConfigError(setting.where, "points.grid." + setting.key,
                              fmt::format("given twice; wanted once, but {} of points.list sets it",
                                          listed.name));
        }
        point.settings.push_back(setting);
    }
    return point;
}

}  // namespace

std::string value_text(const YAML::Node& value) {
    if (value.IsScalar()) return value.Scalar();
    std::string text;
    if (value.IsSequence()) {
        for (const YAML::Node& entry : value) {
            text += (text.empty() ? "" : ", ") + value_text(entry);
        }
        return "[" + text + "]";
    }
    if (!value.IsMap()) return "null";
    for (const auto& entry : value) {
        text +=
            (text.empty() ? "" : ", ") + value_text(entry.first) + ": " + value_text(entry.second);
    }
    return "{" + text + "}";
}

std::vector<Setting> known_entries(const YAML::Node& node, const std::string& path,
                                   const std::string& dotted,
                                   const std::vector<std::string>& known) {
    if (!node.IsMap()) {
        throw ConfigError(position_of(node, path), dotted,
                          fmt::format("got {}, wanted a mapping with the keys {}", found(node),
                                      fmt::join(known, ", ")));
    }
    std::vector<Setting> entries;
    for (const auto& entry : node) {
        const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : found(entry.first);
        const FilePosition where = position_of(entry.first, path);
        if (std::ranges::find(known, name) == known.end()) {
            throw ConfigError(
                where, fmt::format("{}.{}", dotted, name),
                fmt::format("unknown key; the nearest known key is {}", nearest_name(name, known)));
        }
        if (std::ranges::any_of(entries, [&](const Setting& s) { return s.key == name; })) {
            throw ConfigError(where, fmt::format("{}.{}", dotted, name),
                              "given twice; wanted once");
        }
        entries.push_back({name, where, entry.second});
    }
    return entries;
}

std::size_t most_keys(const std::vector<SweepPoint>& points) {
    std::size_t most = 0;
    for (const SweepPoint& point : points) most = std::max(most, point.settings.size());
    return most;
}

std::vector<SweepPoint> read_points(const YAML::Node& node, const std::string& path) {
    std::vector<SweepPoint> listed, grid;
    for (const Setting& entry : known_entries(node, path, "points", {"grid", "list"})) {
        (entry.key == "grid" ? grid : listed) =
            entry.key == "grid" ? grid_points(entry.value, path) : list_points(entry.value, path);
    }
    std::vector<SweepPoint> points;
    if (listed.empty() || grid.empty()) {
        points = listed.empty() ? grid : listed;
    } else {
        require_few(listed.size() * grid.size(), most_keys(listed) + most_keys(grid),
                    position_of(node, path));
        for (const SweepPoint& each : listed) {
            for (const SweepPoint& on_grid : grid) points.push_back(joined(each, on_grid));
        }
    }
    if (points.empty()) {
        throw ConfigError(position_of(node, path), "points", "missing; wanted grid, list or both");
    }
    std::set<std::string> names;
    for (const SweepPoint& point : points) {
        if (names.insert(point.name).second) continue;
        throw ConfigError(
            point.where, "points",
            fmt::format("two points are called {}; wanted every point once", point.name));
    }
    return points;
}

}  // namespace mscomp
