// SPDX-License-Identifier: MIT
// Tables and lists of text: known units, splits, lists of meshes, the rows of a training.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/temporary_folder.h"
#include "cli/acapfeat/mesh_inputs.h"
#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/acap/mesh/natural_order.h"
#include "mscomp/base/index.h"
#include "mscomp/run/split.h"
#include "report/known_units.h"
#include "run/training_log.h"
#include "sweep/sweep_run.h"

namespace mscomp::fuzz {
namespace {

void check_sound(const KnownUnits& units, int shape_count) {
    const auto count = at(units.unit_count());
    require(units.names().size() == count, "every unit has a name");
    std::vector<int> shapes(at(shape_count));
    std::iota(shapes.begin(), shapes.end(), 0);
    for (const int shape : shapes) {
        require(units.of_shape(shape).size() == count, "every shape has all weights");
        for (const double w : units.of_shape(shape)) {
            require(std::isfinite(w), "weights are finite");
        }
    }
    require(units.varying_count(shapes) <= units.unit_count(), "no more units than there are");
    std::vector<double> codes(shapes.begin(), shapes.end());
    const nlohmann::ordered_json matches = units.matches(shapes, codes, std::vector<Component>(1));
    require(matches["list"].size() == count, "every unit is matched or not");
    for (const auto& unit : matches["list"]) {
        const double correlation = unit["best"]["correlation"];
        require(correlation >= 0 && correlation < 1 + 1e-9, "correlations are from 0 to 1");
    }
}

std::vector<std::string> lines_of(std::string_view text) {
    std::vector<std::string> lines;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        lines.emplace_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return lines;
}

/// Sorting by what is no order reads beyond the end.
void check_order(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 8;
    const NaturalOrder order(names);
    const std::size_t count = std::min(names.size(), kMost);
    // Every pair is compared once: names may be as long as the input.
    std::array<std::array<bool, kMost>, kMost> less{};
    for (std::size_t a = 0; a < count; ++a) {
        for (std::size_t b = 0; b < count; ++b) less[a][b] = order.less(names[a], names[b]);
    }
    for (std::size_t a = 0; a < count; ++a) {
        require(!less[a][a], "nothing is less than itself");
        for (std::size_t b = 0; b < count; ++b) {
            require(!(less[a][b] && less[b][a]), "the order has no circles");
            for (std::size_t c = 0; c < count; ++c) {
                require(!(less[a][b] && less[b][c]) || less[a][c], "the order is transitive");
            }
        }
    }
}

}  // namespace

void check_units(std::span<const std::byte> input) {
    static const MemoryFile memory;
    const std::string path = memory.filled_with(input);
    for (const int shape_count : {1, 3}) {
        const auto units = unless_refused(path, [&] { return KnownUnits(path, shape_count); });
        if (units) check_sound(*units, shape_count);
    }
}

void check_split(std::span<const std::byte> input) {
    constexpr int kShapeCount = 8;
    static const MemoryFile memory;
    const std::string path = memory.filled_with(input);
    SplitConfig config;
    config.train = SplitKind::file;
    config.path = path;
    const auto split =
        unless_refused(path, [&] { return resolve_split(config, kShapeCount, "elsewhere"); });
    if (!split) return;
    require(!split->train.empty(), "something trains");
    require(std::ranges::is_sorted(split->train) && std::ranges::is_sorted(split->test),
            "shapes are ascending");
    std::vector<int> all;
    std::ranges::merge(split->train, split->test, std::back_inserter(all));
    std::vector<int> wanted(kShapeCount);
    std::iota(wanted.begin(), wanted.end(), 0);
    require(all == wanted, "every shape trains or tests");
}

void check_list(std::span<const std::byte> input) {
    static const TemporaryFolder folder;
    static const std::string first = folder.put("a.obj", ""), second = folder.put("b.obj", "");
    static const MemoryFile memory;
    // A name beside the meshes for what is in memory.
    static const std::string path = [] {
        std::filesystem::create_symlink(memory.filled_with({}), folder / "list");
        return folder / "list";
    }();
    memory.filled_with(input);
    check_order(lines_of(text_of(input)));
    try {
        const auto meshes = unless_refused(path, [&] { return mesh_paths({}, path); });
        if (!meshes) return;
        require(!meshes->empty(), "there is a mesh");
        for (const std::string& mesh : *meshes) {
            require(std::filesystem::exists(mesh), "every mesh is there");
        }
    } catch (const IoError& error) {
        check_shown(error.what());
    }
}

void check_metrics(std::span<const std::byte> input) {
    constexpr std::int64_t kEpoch = 3;
    static const TemporaryFolder folder;
    const std::string path = folder.put("metrics.csv", text_of(input));
    const auto time = unless_refused(path, [&] { return training_time(folder.path()); });
    require(!time || (time->epochs >= 0 && std::isfinite(time->seconds)), "times are finite");
    const auto kept = [&]() -> std::optional<std::string> {
        return unless_refused(path, [&] {
            const MetricsFile metrics(path, {"level0_reconstruction"}, kEpoch);
            return TemporaryFolder::content(path);
        });
    };
    const auto rows = kept();
    if (!rows) return;
    require(rows->ends_with('\n'), "a row to come begins a line");
    require(kept() == rows, "what was kept is kept");
    require(rows->starts_with("epoch,"), "the first line names the columns");
    require(unless_refused(path, [&] { return training_time(folder.path()); }).has_value(),
            "what was kept can be read");
}

}  // namespace mscomp::fuzz
