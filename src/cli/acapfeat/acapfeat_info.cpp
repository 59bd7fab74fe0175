// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <vector>

#include "acapfeat_commands.h"
#include "cli/number_of.h"
#include "cli/say.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/feature_scaler.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, kFeatureDim> kChannelNames{"r_x", "r_y", "r_z", "S11", "S12",
                                                             "S13", "S22", "S23", "S33"};
constexpr std::size_t kJumpsShown = 5;

// Smallest and largest r, smallest and largest entry of S.
struct Extremes {
    FeatureExtreme lowest_rotation, highest_rotation, lowest_stretch, highest_stretch;

    void add(const FeatureExtreme& found) {
        const bool is_rotation = found.channel < kRotationDim;
        FeatureExtreme& lowest = is_rotation ? lowest_rotation : lowest_stretch;
        FeatureExtreme& highest = is_rotation ? highest_rotation : highest_stretch;
        if (lowest.shape < 0 || found.value < lowest.value) lowest = found;
        if (highest.shape < 0 || found.value > highest.value) highest = found;
    }
};

Extremes extremes_of_shape(const FeatureFile& file, int shape) {
    Extremes extremes;
    const std::span<const float> values = file.shape(shape);
    for (std::size_t k = 0; k < values.size(); ++k) {
        extremes.add({values[k], shape, static_cast<int>(k / kFeatureDim),
                      static_cast<int>(k % kFeatureDim)});
    }
    file.forget(shape);
    return extremes;
}

Extremes extremes_of(const FeatureFile& file) {
    std::vector<Extremes> shapes(at(file.shape_count()));
    parallel_for(file.shape_count(), [&](std::int64_t n) {
        shapes[at(n)] = extremes_of_shape(file, static_cast<int>(n));
    });
    Extremes all;
    for (const Extremes& shape : shapes) {
        for (const FeatureExtreme& extreme : {shape.lowest_rotation, shape.highest_rotation,
                                              shape.lowest_stretch, shape.highest_stretch}) {
            all.add(extreme);
        }
    }
    return all;
}

// The shapes with the largest jumps, largest first.
std::vector<int> largest_jumps(const FeatureSet& set) {
    std::vector<int> order(set.largest_jump.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&set](int a, int b) {
        return set.largest_jump[at(a)] > set.largest_jump[at(b)];
    });
    order.resize(std::min(order.size(), kJumpsShown));
    return order;
}

Json to_json(const FeatureSet& set, const FeatureExtreme& extreme) {
    return {{"value", extreme.value},
            {"shape", set.names[at(extreme.shape)]},
            {"shape_index", extreme.shape},
            {"vertex", extreme.vertex},
            {"channel", kChannelNames[at(extreme.channel)]}};
}

std::string to_text(const FeatureSet& set, const FeatureExtreme& extreme) {
    return fmt::format("{:.4g} ({} of shape {}, vertex {})", extreme.value,
                       kChannelNames[at(extreme.channel)], set.names[at(extreme.shape)],
                       extreme.vertex + 1);
}

double total_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

int proved_count(const FeatureSet& set) {
    int count = 0;
    for (int n = 0; n < set.shape_count(); ++n) count += set.is_proved(n) ? 1 : 0;
    return count;
}

void print_json(const FeatureFile& file) {
    const PlacedFeatures& set = file.outline();
    Json info{{"file", file.path()},
              {"shapes", set.shape_count()},
              {"vertices", set.vertex_count()},
              {"faces", set.reference.face_count()},
              {"weights", set.weights},
              {"coincident_vertices", set.places.coincident_count()},
              {"unused_vertices", set.places.unused_count()}};
    const Extremes extremes = extremes_of(file);
    info["rotation_vector"] = {{"lowest", to_json(set, extremes.lowest_rotation)},
                               {"highest", to_json(set, extremes.highest_rotation)}};
    info["stretch"] = {{"lowest", to_json(set, extremes.lowest_stretch)},
                       {"highest", to_json(set, extremes.highest_stretch)}};
    info["names"] = set.names;
    info["principal_energy"] = set.principal_energy;
    info["propagation_energy"] = set.propagation_energy;
    info["relaxation_energy"] = set.relaxation_energy;  // null where it was not needed
    info["consistency_energy"] = set.consistency_energy;
    info["consistency_gap"] = set.consistency_gap;
    info["proved"] = proved_count(set);
    info["largest_jump"] = set.largest_jump;
    info["large_jumps"] = set.large_jumps;
    info["inherent_jumps"] = set.inherent_jumps;
    info["removable_jumps"] = set.removable_jumps;
    info["warnings"] = set.warnings;
    print_lines(json_text(info, 2) + "\n");
}

void print_energies(const FeatureSet& set) {
    const auto print = [](const char* label, const std::vector<double>& values) {
        if (!values.empty()) print_out("{:<19} {:.6g} in all\n", label, total_of(values));
    };
    print("consistency energy", set.consistency_energy);
    print("  principal", set.principal_energy);
    print("  propagation", set.propagation_energy);
    print("gap to lower bound", set.consistency_gap);
    if (!set.consistency_gap.empty()) {
        print_out("proved least        {} of {}\n", proved_count(set),
                  number_of_shapes(set.shape_count()));
    }
    for (const int i : largest_jumps(set)) {
        const auto index = at(i);
        print_out("jump across an edge {:.4g} rad in shape {}\n", set.largest_jump[index],
                  set.names[index]);
    }
}

void print_jumps(const FeatureSet& set) {
    if (set.large_jumps.empty() || set.inherent_jumps.empty() || set.removable_jumps.empty()) {
        return;
    }
    print_out(
        "jumps above pi      {} edges of all shapes; {} whatever the turns, {} perhaps "
        "removable\n",
        total_of(set.large_jumps), total_of(set.inherent_jumps), total_of(set.removable_jumps));
}

void print_text(const FeatureFile& file) {
    const PlacedFeatures& set = file.outline();
    print_out("file                {}\n", file.path());
    print_out("shapes              {}\n", set.shape_count());
    print_out("vertices            {}\n", set.vertex_count());
    print_out("faces               {}\n", set.reference.face_count());
    print_out("weights             {}\n", set.weights);
    if (!set.places.are_all_vertices()) {
        print_out("places              {}: {} vertices coincide with others, {} are in no face\n",
                  set.places.place_count(set.vertex_count()), set.places.coincident_count(),
                  set.places.unused_count());
    }
    const Extremes extremes = extremes_of(file);
    print_out("r, radians          from {}\n", to_text(set, extremes.lowest_rotation));
    print_out("                    to {}\n", to_text(set, extremes.highest_rotation));
    print_out("S                   from {}\n", to_text(set, extremes.lowest_stretch));
    print_out("                    to {}\n", to_text(set, extremes.highest_stretch));
    print_out("                    vertices counted from 1 (from 0 with --json)\n");
    print_energies(set);
    print_jumps(set);
    print_out("warnings            {}\n", set.warnings.empty() ? "none" : "");
    for (const std::string& warning : set.warnings) print_out("  {}\n", warning);
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
    const FeatureFile file(options.features);
    if (options.common.json) {
        print_json(file);
    } else {
        print_text(file);
    }
}

}  // namespace mscomp
