// SPDX-License-Identifier: MIT
#include "mscomp/nn/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "model_arrays.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/safetensors.h"

namespace mscomp::nn {
namespace {

constexpr const char* kFormat = "mscomp-model";
constexpr int kFormatVersion = 1;

/// Runs `read`, turning whatever is wrong with the file into a CheckpointError.
template <class Read>
auto as_checkpoint(const std::string& path, Read&& read) {
    try {
        return read();
    } catch (const InputError& error) {
        throw CheckpointError(path, fmt::format("not a usable model file ({})", error.what()));
    } catch (const nlohmann::json::exception& error) {
        throw CheckpointError(path, fmt::format("damaged metadata ({})", error.what()));
    }
}

template <class To, std::size_t N>
std::vector<To> flat(const std::vector<std::array<To, N>>& rows) {
    std::vector<To> values;
    values.reserve(rows.size() * N);
    for (const auto& row : rows) values.insert(values.end(), row.begin(), row.end());
    return values;
}

template <class To, std::size_t N>
std::vector<std::array<To, N>> unflat(std::span<const To> values) {
    std::vector<std::array<To, N>> rows(values.size() / N);
    for (std::size_t i = 0; i < values.size(); ++i) rows[i / N][i % N] = values[i];
    return rows;
}

std::string parameter_key(const char* prefix, const std::string& name) {
    return fmt::format("{}/{}", prefix, name);
}

nlohmann::json describe(const ModelContext& context, const TrainingState& state) {
    return {{"format", kFormat},
            {"format_version", kFormatVersion},
            {"config", context.config},
            {"source", context.source},
            {"source_hash", context.source_hash},
            {"weights", context.weights},
            {"largest_distance_exact", context.largest_distance_exact},
            {"epoch", state.epoch},
            {"step", state.step}};
}

}  // namespace

void write_model(const std::string& path, Model<float>& model, const ModelContext& context,
                 const TrainingState& state, const std::vector<std::vector<float>>& codes) {
    ModelArrays arrays;
    // The writer borrows, so everything made for it lives until write().
    const std::vector<double> reference = flat(context.reference.vertices);
    const std::vector<int> faces = flat(context.reference.faces);
    const std::array<double, 2> numbers{context.largest_distance, state.total};
    const std::array<double, 4> window{state.window_mean, state.window_sum,
                                       state.is_plateau ? 1.0 : 0.0,
                                       static_cast<double>(state.window_epochs)};
    const auto count = [](const auto& values) { return static_cast<std::int64_t>(values.size()); };
    arrays.add<double>("reference", {context.reference.vertex_count(), 3}, reference);
    arrays.add<int>("faces", {context.reference.face_count(), 3}, faces);
    arrays.add<double>("scaler_offset", {kFeatureDim}, context.offset);
    arrays.add<double>("scaler_factor", {kFeatureDim}, context.factor);
    arrays.add<double>("minmax_offset", {kFeatureDim}, context.minmax_offset);
    arrays.add<double>("minmax_factor", {kFeatureDim}, context.minmax_factor);
    arrays.add<double>("largest_distance_and_total", {2}, numbers);
    arrays.add<double>("plateau", {4}, window);
    arrays.add<int>("train_shapes", {count(context.train_shapes)}, context.train_shapes);
    arrays.add<int>("test_shapes", {count(context.test_shapes)}, context.test_shapes);

    ParameterSet<float>& parameters = model.parameters();
    for (int i = 0; i < parameters.count(); ++i) {
        const auto& entry = parameters.entry(i);
        const auto add = [&](const char* prefix, std::span<const float> inner) {
            arrays.add_inner(parameter_key(prefix, entry.name), entry.extents, inner,
                             model.order());
        };
        add("parameter", parameters.value(i));
        add("adam_m", parameters.moment1(i));
        add("adam_v", parameters.moment2(i));
    }
    const std::vector<LevelSize> levels = model.level_sizes();
    std::vector<std::vector<int>> centers;
    centers.reserve(levels.size());
    for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
        centers.push_back(model.centers(l));
        arrays.add<int>(fmt::format("centers/level{}", l), {count(centers.back())}, centers.back());
    }
    // Who acts is decided in some steps only, so it is part of the state.
    const std::vector<std::uint8_t> acting = model.acting_vertices();
    if (!acting.empty()) {
        arrays.add<std::uint8_t>(
            "acting", {count(acting) / model.vertex_count(), model.vertex_count()}, acting);
    }
    for (std::size_t l = 0; l < codes.size(); ++l) {
        const std::int64_t width = levels[l].codes();
        arrays.add<float>(fmt::format("codes/level{}", l), {count(codes[l]) / width, width},
                          codes[l]);
    }
    arrays.write(path, {{"model", describe(context, state).dump()}});
}

struct ModelFile::Content {
    SafetensorsFile file;
    ModelContext context;
    TrainingState state;
    std::vector<std::vector<float>> codes;

    explicit Content(const std::string& path) : file(path) {
        const auto found = file.metadata().find("model");
        if (found == file.metadata().end()) {
            throw CheckpointError(path, "a safetensors file, but not a model of mscomp");
        }
        const nlohmann::json description = nlohmann::json::parse(found->second);
        if (description.at("format_version") != kFormatVersion) {
            throw CheckpointError(
                path, fmt::format("model format {}, this program reads {}",
                                  description.at("format_version").dump(), kFormatVersion));
        }
        context.config = description.at("config");
        context.source = description.at("source");
        context.source_hash = description.at("source_hash");
        context.weights = description.at("weights");
        context.largest_distance_exact = description.at("largest_distance_exact");
        state.epoch = description.at("epoch");
        state.step = description.at("step");
        context.reference.vertices = unflat<double, 3>(file.data<double>("reference", {-1, 3}));
        context.reference.faces = unflat<int, 3>(file.data<int>("faces", {-1, 3}));
        const auto nine = [&](const char* name, std::array<double, kFeatureDim>& to) {
            std::ranges::copy(file.data<double>(name, {kFeatureDim}), to.begin());
        };
        nine("scaler_offset", context.offset);
        nine("scaler_factor", context.factor);
        nine("minmax_offset", context.minmax_offset);
        nine("minmax_factor", context.minmax_factor);
        const auto numbers = file.data<double>("largest_distance_and_total", {2});
        context.largest_distance = numbers[0];
        state.total = numbers[1];
        if (file.contains("plateau")) read_window(file.data<double>("plateau", {-1}));
        const auto indices = [&](const char* name) {
            const auto values = file.data<int>(name, {-1});
            return std::vector<int>(values.begin(), values.end());
        };
        context.train_shapes = indices("train_shapes");
        context.test_shapes = indices("test_shapes");
        for (int l = 0; file.contains(fmt::format("codes/level{}", l)); ++l) {
            const auto values = file.data<float>(fmt::format("codes/level{}", l), {-1, -1});
            codes.emplace_back(values.begin(), values.end());
        }
        check_faces(path);
        check_shapes(path);
    }

    void read_window(std::span<const double> window) {
        if (window.size() < 3) return;
        state.window_mean = window[0];
        state.is_plateau = window[2] != 0;
        // Early files do not say how many epochs the sum is of: their window begins anew.
        if (window.size() < 4) return;
        state.window_sum = window[1];
        state.window_epochs = static_cast<std::int64_t>(window[3]);
    }

    void check_shapes(const std::string& path) const {
        for (const auto* shapes : {&context.train_shapes, &context.test_shapes}) {
            if (!std::ranges::is_sorted(*shapes) || (!shapes->empty() && shapes->front() < 0)) {
                throw CheckpointError(path, "indices of shapes are not ascending from 0");
            }
        }
    }

    void check_faces(const std::string& path) const {
        for (const Face& face : context.reference.faces) {
            for (const int v : face) {
                if (v < 0 || v >= context.reference.vertex_count()) {
                    throw CheckpointError(path, fmt::format("a face refers to vertex {}, the "
                                                            "reference has {}",
                                                            v, context.reference.vertex_count()));
                }
            }
        }
    }
};

ModelFile::ModelFile(const std::string& path)
    : content_(as_checkpoint(path, [&] { return std::make_unique<Content>(path); })) {}
ModelFile::ModelFile(ModelFile&&) noexcept = default;
ModelFile& ModelFile::operator=(ModelFile&&) noexcept = default;
ModelFile::~ModelFile() = default;

const ModelContext& ModelFile::context() const { return content_->context; }
const TrainingState& ModelFile::state() const { return content_->state; }
const std::vector<std::vector<float>>& ModelFile::codes() const { return content_->codes; }

void ModelFile::load_centers(Model<float>& model) const {
    const std::vector<LevelSize> levels = model.level_sizes();
    const auto shapes = static_cast<std::int64_t>(context().train_shapes.size());
    for (int l = 0; l < static_cast<int>(levels.size()); ++l) {
        const std::int64_t rows = levels[at(l)].codes();
        content_->file.data<float>(fmt::format("codes/level{}", l), {shapes, rows});
        const auto centers = content_->file.data<int>(fmt::format("centers/level{}", l), {rows});
        for (const int center : centers) {
            if (center >= 0 && center < model.vertex_count()) continue;
            throw CheckpointError(content_->file.path(), fmt::format("centre {} of {} vertices",
                                                                     center, model.vertex_count()));
        }
        model.set_centers(l, {centers.begin(), centers.end()});
    }
}

void ModelFile::load_acting(Model<float>& model) const {
    std::span<const std::uint8_t> acting;
    if (content_->file.contains("acting")) {
        const std::int64_t autoencoders = model.level_sizes().back().autoencoders;
        acting = content_->file.data<std::uint8_t>("acting", {autoencoders, model.vertex_count()});
    }
    if (!model.restore_acting_vertices(acting)) {
        throw CheckpointError(content_->file.path(), "component weights where nothing acts");
    }
}

void ModelFile::load(Model<float>& model) const {
    as_checkpoint(content_->file.path(), [&] {
        ParameterSet<float>& parameters = model.parameters();
        for (int i = 0; i < parameters.count(); ++i) {
            const auto& entry = parameters.entry(i);
            const auto read = [&](const char* prefix, std::span<float> to) {
                return read_inner(content_->file, parameter_key(prefix, entry.name), entry.extents,
                                  model.order(), to);
            };
            if (!read("parameter", parameters.value(i))) {
                throw CheckpointError(content_->file.path(), "a parameter is not finite");
            }
            read("adam_m", parameters.moment1(i));
            read("adam_v", parameters.moment2(i));
        }
        load_centers(model);
        load_acting(model);
    });
}

}  // namespace mscomp::nn
