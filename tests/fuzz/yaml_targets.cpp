// SPDX-License-Identifier: MIT
#include <algorithm>
#include <set>

#include "base/temporary_folder.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/base/printable.h"
#include "mscomp/config/config_file.h"
#include "sweep/sweep_file.h"
#include "sweep/sweep_table.h"

namespace mscomp::fuzz {
namespace {

/// Every field is written, so that texts are equal where configurations are.
void check_round_trip(const Config& config) {
    const std::string plain = write_config(config, false);
    for (const bool with_comments : {false, true}) {
        const std::string text = write_config(config, with_comments);
        require(write_config(parse_config(text, "written"), false) == plain,
                "a configuration survives writing and reading");
    }
}

/// "key=value" as behind --set; the shell and we show it in messages as it was typed.
void check_override(std::string_view text) {
    const std::string set(text);
    if (printable(set) != set) return;
    const auto config = unless_refused<ConfigError>(
        "--set " + set, [&] { return parse_config("data: {features: f}", "input", {set}); });
    if (config) check_round_trip(*config);
}

/// A point has a folder of its own in that of the sweep.
void check_names(const std::vector<SweepPoint>& points) {
    std::set<std::string> names;
    for (const SweepPoint& point : points) {
        require(names.insert(point.name).second, "names are distinct");
        require(!point.name.empty() && point.name.front() != '.' &&
                    point.name.find('/') == std::string::npos && point.name.size() < 256,
                "a name is that of a folder");
        check_shown(point.name);
    }
}

/// Base and sweep lie in `folder`.
void check_points(const SweepFile& sweep, const std::string& folder) {
    constexpr std::size_t kMost = 16;
    for (std::size_t i = 0; i < std::min(sweep.points.size(), kMost); ++i) {
        const SweepPoint& point = sweep.points[i];
        const auto config =
            unless_refused<ConfigError>(folder, [&] { return point_config(sweep, point, {}); });
        if (!config) continue;
        check_round_trip(*config);
        require(varied_values(sweep, point, *config).size() == sweep.keys.size(),
                "every key that varies has a value");
    }
}

}  // namespace

void check_config(std::span<const std::byte> input) {
    const auto config =
        unless_refused<ConfigError>("input", [&] { return parse_config(text_of(input), "input"); });
    if (config) check_round_trip(*config);
    check_override(text_of(input));
}

void check_sweep(std::span<const std::byte> input) {
    static const TemporaryFolder folder;
    static const std::string base = folder.put("base.yaml", config_template("autoencoder"));
    const std::string path = folder.put("sweep", text_of(input));
    try {
        const auto sweep =
            unless_refused<ConfigError>(folder.path(), [&] { return read_sweep(path); });
        if (!sweep) return;
        require(!sweep->points.empty(), "there is a point");
        check_names(sweep->points);
        check_points(*sweep, folder.path());
    } catch (const IoError& error) {
        check_shown(error.what());  // the configuration that it names
    } catch (const InputError& error) {
        check_refusal(error, folder.path());  // a file of another kind
    }
}

}  // namespace mscomp::fuzz
