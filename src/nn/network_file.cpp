// SPDX-License-Identifier: MIT
// The arrays of a network in a model file: parameters, Adam's moments, centres, who acts.
#include <fmt/format.h>

#include <algorithm>

#include "model_arrays.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "nn/network.h"

namespace mscomp::nn {
namespace {

std::string parameter_key(const char* prefix, const std::string& name) {
    return fmt::format("{}/{}", prefix, name);
}

std::string centers_key(int level) { return fmt::format("centers/level{}", level); }

void load_parameters(Model<float>& model, const SafetensorsFile& file) {
    ParameterSet<float>& parameters = model.parameters();
    for (int i = 0; i < parameters.count(); ++i) {
        const auto& entry = parameters.entry(i);
        const auto read = [&](const char* prefix, std::span<float> to) {
            read_inner(file, parameter_key(prefix, entry.name), entry.extents, model.order(), to);
        };
        read("parameter", parameters.value(i));
        read("adam_m", parameters.moment1(i));
        read("adam_v", parameters.moment2(i));
    }
}

void load_centers(Model<float>& model, const SafetensorsFile& file) {
    const std::vector<LevelSize> levels = model.level_sizes();
    for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
        const auto centers = file.data<int>(centers_key(l), {levels[at(l)].codes()});
        for (const int center : centers) {
            if (center >= 0 && center < model.vertex_count()) continue;
            throw CheckpointError(
                file.path(), fmt::format("centre {} of {} vertices", center, model.vertex_count()));
        }
        model.set_centers(l, {centers.begin(), centers.end()});
    }
}

/// Who acts is decided in some steps only, so it is part of the state.
void load_acting(Model<float>& model, const SafetensorsFile& file) {
    std::span<const std::uint8_t> acting;
    if (file.contains("acting")) {
        const std::int64_t autoencoders = model.level_sizes().back().autoencoders;
        acting = file.data<std::uint8_t>("acting", {autoencoders, model.vertex_count()});
    }
    if (!model.restore_acting_vertices(acting)) {
        throw CheckpointError(file.path(), "component weights where nothing acts");
    }
}

}  // namespace

void Network::save(StoredArrays& arrays) const {
    const ParameterSet<float>& parameters = std::as_const(model_).parameters();
    for (int i = 0; i < parameters.count(); ++i) {
        const auto& entry = parameters.entry(i);
        const auto add = [&](const char* prefix, std::span<const float> inner) {
            add_inner(arrays, parameter_key(prefix, entry.name), entry.extents, inner,
                      model_.order());
        };
        add("parameter", parameters.value(i));
        add("adam_m", parameters.moment1(i));
        add("adam_v", parameters.moment2(i));
    }
    const int level_count = static_cast<int>(levels().size());
    for (int l = 0; l < level_count; ++l) {
        std::vector<int> centers = model_.centers(l);
        const auto count = static_cast<std::int64_t>(centers.size());
        arrays.keep<int>(centers_key(l), {count}, std::move(centers));
    }
    std::vector<std::uint8_t> acting = model_.acting_vertices();
    if (!acting.empty()) {
        const auto count = static_cast<std::int64_t>(acting.size());
        arrays.keep<std::uint8_t>("acting", {count / vertex_count(), vertex_count()},
                                  std::move(acting));
    }
}

void Network::load(const SafetensorsFile& file) {
    forget_decoder();
    load_parameters(model_, file);
    load_centers(model_, file);
    load_acting(model_, file);
}

}  // namespace mscomp::nn
