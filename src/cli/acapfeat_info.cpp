// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "acapfeat_commands.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/feature_scaler.h"

namespace mscomp {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, kFeatureDim> kChannelNames{"r_x", "r_y", "r_z", "S11", "S12",
                                                             "S13", "S22", "S23", "S33"};
constexpr std::size_t kJumpsShown = 5;

// Smallest and largest r, smallest and largest entry of S, over all shapes.
std::vector<FeatureExtreme> extremes_of(const FeatureSet& set) {
    std::vector<int> all(static_cast<std::size_t>(set.shape_count()));
    std::iota(all.begin(), all.end(), 0);
    return FeatureScaler::fit(set, all, FeatureCenter::minmax).extremes;
}

// The shapes with the largest jumps, largest first.
std::vector<int> largest_jumps(const FeatureSet& set) {
    std::vector<int> order(set.largest_jump.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&set](int a, int b) {
        return set.largest_jump[static_cast<std::size_t>(a)] >
               set.largest_jump[static_cast<std::size_t>(b)];
    });
    order.resize(std::min(order.size(), kJumpsShown));
    return order;
}

Json to_json(const FeatureSet& set, const FeatureExtreme& extreme) {
    return {{"value", extreme.value},
            {"shape", set.names[static_cast<std::size_t>(extreme.shape)]},
            {"shape_index", extreme.shape},
            {"vertex", extreme.vertex},
            {"channel", kChannelNames[static_cast<std::size_t>(extreme.channel)]}};
}

std::string to_text(const FeatureSet& set, const FeatureExtreme& extreme) {
    return fmt::format("{:.4g} ({} of shape {}, vertex {})", extreme.value,
                       kChannelNames[static_cast<std::size_t>(extreme.channel)],
                       set.names[static_cast<std::size_t>(extreme.shape)], extreme.vertex);
}

double total_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

void print_json(const FeatureSet& set, const std::string& path) {
    Json info{{"file", path},
              {"shapes", set.shape_count()},
              {"vertices", set.vertex_count()},
              {"faces", set.reference.face_count()},
              {"weights", set.weights}};
    const std::vector<FeatureExtreme> extremes = extremes_of(set);
    info["rotation_vector"] = {{"lowest", to_json(set, extremes[0])},
                               {"highest", to_json(set, extremes[1])}};
    info["stretch"] = {{"lowest", to_json(set, extremes[2])},
                       {"highest", to_json(set, extremes[3])}};
    info["names"] = set.names;
    info["consistency_energy"] = set.consistency_energy;
    info["consistency_gap"] = set.consistency_gap;
    info["largest_jump"] = set.largest_jump;
    info["warnings"] = set.warnings;
    fmt::print("{}\n", info.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_text(const FeatureSet& set, const std::string& path) {
    fmt::print("file                {}\n", path);
    fmt::print("shapes              {}\n", set.shape_count());
    fmt::print("vertices            {}\n", set.vertex_count());
    fmt::print("faces               {}\n", set.reference.face_count());
    fmt::print("weights             {}\n", set.weights);
    const std::vector<FeatureExtreme> extremes = extremes_of(set);
    fmt::print("r, radians          from {}\n", to_text(set, extremes[0]));
    fmt::print("                    to {}\n", to_text(set, extremes[1]));
    fmt::print("S                   from {}\n", to_text(set, extremes[2]));
    fmt::print("                    to {}\n", to_text(set, extremes[3]));
    if (!set.consistency_energy.empty()) {
        fmt::print("consistency energy  {:.6g} in all\n", total_of(set.consistency_energy));
    }
    if (!set.consistency_gap.empty()) {
        fmt::print("gap to lower bound  {:.6g} in all\n", total_of(set.consistency_gap));
    }
    for (const int i : largest_jumps(set)) {
        const auto index = static_cast<std::size_t>(i);
        fmt::print("jump across an edge {:.4g} rad in shape {}\n", set.largest_jump[index],
                   set.names[index]);
    }
    fmt::print("warnings            {}\n", set.warnings.empty() ? "none" : "");
    for (const std::string& warning : set.warnings) fmt::print("  {}\n", warning);
}

}  // namespace

void setup_info(CLI::App& app) {
    const auto options = std::make_shared<InfoCommand>();
    CLI::App* command = app.add_subcommand("info", "What is in a feature file");
    command->add_option("FEATURES", options->features, "Feature file")->required();
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat info swing.safetensors --json");
    command->callback([options] { run_info(*options); });
}

void run_info(const InfoCommand& options) {
    const FeatureSet set = read_features(options.features);
    if (options.common.json) {
        print_json(set, options.features);
    } else {
        print_text(set, options.features);
    }
}

}  // namespace mscomp
