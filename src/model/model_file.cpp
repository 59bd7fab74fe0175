// SPDX-License-Identifier: MIT
#include "mscomp/model/model_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/finite.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"

namespace mscomp {
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

nlohmann::json describe(const ModelContext& context, const TrainingState& state) {
    return {{"format", kFormat},
            {"format_version", kFormatVersion},
            {"config", context.config},
            {"source", context.source},
            {"source_hash", context.source_hash},
            {"start_hash", context.start_hash},
            {"weights", context.weights},
            {"largest_distance_exact", context.largest_distance_exact},
            {"epoch", state.epoch},
            {"step", state.step}};
}

/// The whole number, at least 0, under `key`. Throws CheckpointError.
std::int64_t count_in(const nlohmann::json& description, const char* key, const std::string& path) {
    const nlohmann::json& entry = description.at(key);
    const std::int64_t count = entry.is_number_integer() ? entry.get<std::int64_t>() : -1;
    if (count >= 0) return count;
    throw CheckpointError(path, fmt::format("{} is no whole number of at least 0", key));
}

std::string codes_key(int level) { return fmt::format("codes/level{}", level); }

/// Columns [first, first + count) of the table, row after row.
std::vector<float> columns(const CodeTable& codes, int first, int count) {
    std::vector<float> values;
    for (int m = 0; m < codes.shape_count(); ++m) {
        const std::span<const float> row = codes.shape(m).subspan(at(first), at(count));
        values.insert(values.end(), row.begin(), row.end());
    }
    return values;
}

/// Tables (n,K) of the same n shapes side by side.
CodeTable joined(const std::vector<std::span<const float>>& tables, std::size_t shapes) {
    CodeTable codes;
    for (std::size_t m = 0; m < shapes; ++m) {
        for (const std::span<const float> table : tables) {
            const std::size_t width = table.size() / shapes;
            const std::span<const float> row = table.subspan(m * width, width);
            codes.values.insert(codes.values.end(), row.begin(), row.end());
        }
    }
    codes.code_count = shapes > 0 ? static_cast<int>(codes.values.size() / shapes) : 0;
    return codes;
}

}  // namespace

TriangleMesh ModelContext::whole(std::span<const Point> positions) const {
    TriangleMesh result = mesh();
    places.to_vertices(positions, std::span(result.vertices));
    return result;
}

void write_model(const std::string& path, const LearnedModel& model, const ModelContext& context,
                 const TrainingState& state, const CodeTable& codes) {
    StoredArrays arrays;
    const auto count = [](const auto& values) { return static_cast<std::int64_t>(values.size()); };
    const TriangleMesh& mesh = context.mesh();
    arrays.keep<double>("reference", {mesh.vertex_count(), 3}, flat(mesh.vertices));
    arrays.keep<int>("faces", {mesh.face_count(), 3}, flat(mesh.faces));
    if (!context.places.are_all_vertices()) {
        arrays.add<int>("place", {mesh.vertex_count()}, context.places.place_of_vertex());
    }
    arrays.add<double>("scaler_offset", {kFeatureDim}, context.scale.offset);
    arrays.add<double>("scaler_factor", {kFeatureDim}, context.scale.factor);
    if (!context.scale.roots.empty()) {
        arrays.add<float>("scaler_roots", {count(context.scale.roots)}, context.scale.roots);
    }
    arrays.add<double>("minmax_offset", {kFeatureDim}, context.minmax.offset);
    arrays.add<double>("minmax_factor", {kFeatureDim}, context.minmax.factor);
    arrays.keep<double>("largest_distance_and_total", {2}, {context.largest_distance, state.total});
    arrays.keep<double>("plateau", {4},
                        {state.window_mean, state.window_sum, state.is_plateau ? 1.0 : 0.0,
                         static_cast<double>(state.window_epochs)});
    arrays.keep<double>("divergence", {2}, {state.rate_factor, state.first_error});
    if (context.squared_error) {
        arrays.keep<double>("squared_error", {1}, {*context.squared_error});
    }
    arrays.add<int>("train_shapes", {count(context.train_shapes)}, context.train_shapes);
    arrays.add<int>("test_shapes", {count(context.test_shapes)}, context.test_shapes);
    model.save(arrays);
    int first = 0, number = 0;
    for (const LevelSize& level : model.levels()) {
        arrays.keep<float>(codes_key(number++), {codes.shape_count(), level.codes()},
                           columns(codes, first, level.codes()));
        first += level.codes();
    }
    arrays.write(path, {{"model", json_text(describe(context, state))}});
}

struct ModelFile::Content {
    std::string not_finite;  // what is, of any array; empty if all numbers are
    SafetensorsFile file;
    ModelContext context;
    TrainingState state;
    CodeTable codes;

    explicit Content(const std::string& path)
        : file(path, [this](const SafetensorsPiece& piece) { look_for_non_finite(piece); }) {
        const auto found = file.metadata().find("model");
        if (found == file.metadata().end()) {
            throw CheckpointError(path, "a safetensors file, but not a model of mscomp");
        }
        if (!not_finite.empty()) {
            throw CheckpointError(path, not_finite + ", wanted a finite number");
        }
        const nlohmann::json description = parsed_json<nlohmann::json>(found->second, path);
        if (description.at("format_version") != kFormatVersion) {
            throw CheckpointError(
                path, fmt::format("model format {}, this program reads {}",
                                  json_text(description.at("format_version")), kFormatVersion));
        }
        context.config = description.at("config");
        context.source = description.at("source");
        context.source_hash = description.at("source_hash");
        context.start_hash = description.value("start_hash", std::string());
        context.weights = description.at("weights");
        context.largest_distance_exact = description.at("largest_distance_exact");
        state.epoch = count_in(description, "epoch", path);
        state.step = count_in(description, "step", path);
        context.reference.vertices = unflat<double, 3>(file.data<double>("reference", {-1, 3}));
        context.reference.faces = unflat<int, 3>(file.data<int>("faces", {-1, 3}));
        const auto nine = [&](const char* name, std::array<double, kFeatureDim>& to) {
            std::ranges::copy(file.data<double>(name, {kFeatureDim}), to.begin());
        };
        nine("scaler_offset", context.scale.offset);
        nine("scaler_factor", context.scale.factor);
        nine("minmax_offset", context.minmax.offset);
        nine("minmax_factor", context.minmax.factor);
        const auto numbers = file.data<double>("largest_distance_and_total", {2});
        if (numbers[0] < 0) {
            throw CheckpointError(
                path, fmt::format("got a largest distance of {}, wanted one >= 0", numbers[0]));
        }
        context.largest_distance = numbers[0];
        state.total = numbers[1];
        if (file.contains("plateau")) read_window(file.data<double>("plateau", {-1}));
        if (file.contains("divergence")) read_divergence(file.data<double>("divergence", {2}));
        if (file.contains("squared_error")) read_error(file.data<double>("squared_error", {1}));
        const auto indices = [&](const char* name) {
            const auto values = file.data<int>(name, {-1});
            return std::vector<int>(values.begin(), values.end());
        };
        context.train_shapes = indices("train_shapes");
        context.test_shapes = indices("test_shapes");
        read_codes();
        check_faces(path);
        check_shapes(path);
        if (file.contains("place")) read_places(path);
        read_roots();
    }

    /// The reference was read as the files have it.
    void read_places(const std::string& path) {
        TriangleMesh& mesh = context.reference_of_files = std::move(context.reference);
        const auto place = file.data<int>("place", {mesh.vertex_count()});
        try {
            context.places = VertexPlaces::from_stored({place.begin(), place.end()}, mesh.faces);
        } catch (const MeshError& error) {
            throw CheckpointError(path, error.what());
        }
        context.reference = context.places.surface(mesh);
    }

    void look_for_non_finite(const SafetensorsPiece& piece) {
        if (!not_finite.empty()) return;
        if (const auto place = first_non_finite(piece)) not_finite = piece.name + *place;
    }

    void read_codes() {
        std::vector<std::span<const float>> tables;
        const auto shapes = static_cast<std::int64_t>(context.train_shapes.size());
        for (int l = 0; file.contains(codes_key(l)); ++l) {
            tables.push_back(file.data<float>(codes_key(l), {shapes, -1}));
        }
        codes = joined(tables, context.train_shapes.size());
    }

    void read_roots() {
        if (!file.contains("scaler_roots")) return;
        const auto roots = file.data<float>("scaler_roots", {context.reference.vertex_count()});
        if (!std::ranges::all_of(roots, [](float root) { return root > 0; })) {
            throw CheckpointError(file.path(), "a root of the metric is not positive");
        }
        context.scale.roots.assign(roots.begin(), roots.end());
    }

    void read_window(std::span<const double> window) {
        if (window.size() < 3) return;
        state.window_mean = window[0];
        state.is_plateau = window[2] != 0;
        // Early files do not say how many epochs the sum is of: their window begins anew.
        if (window.size() < 4) return;
        constexpr double kMostEpochs = 1e9;
        if (!(window[3] >= 0 && window[3] <= kMostEpochs)) {
            throw CheckpointError(file.path(), "the epochs of the plateau window are none");
        }
        state.window_sum = window[1];
        state.window_epochs = static_cast<std::int64_t>(window[3]);
    }

    /// Files from before training could go back have neither.
    void read_divergence(std::span<const double> numbers) {
        state.rate_factor = numbers[0];
        state.first_error = numbers[1];
        if (state.rate_factor > 0 && state.rate_factor <= 1 && state.first_error >= 0) return;
        throw CheckpointError(file.path(),
                              fmt::format("rate factor {}, first error {}; wanted above 0 and at "
                                          "most 1, and at least 0",
                                          state.rate_factor, state.first_error));
    }

    void read_error(std::span<const double> error) {
        context.squared_error = error[0];
        if (error[0] >= 0) return;
        throw CheckpointError(file.path(),
                              fmt::format("got a squared error of {}, wanted one >= 0", error[0]));
    }

    void check_shapes(const std::string& path) const {
        for (const auto* shapes : {&context.train_shapes, &context.test_shapes}) {
            if (!std::ranges::is_sorted(*shapes) || (!shapes->empty() && shapes->front() < 0)) {
                throw CheckpointError(path, "indices of shapes are not ascending from 0");
            }
        }
    }

    void check_faces(const std::string& path) const {
        if (context.reference.vertices.empty() || context.reference.faces.empty()) {
            throw CheckpointError(path, "the reference has no vertices or no faces");
        }
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

const std::string& ModelFile::path() const { return content_->file.path(); }
std::string ModelFile::data_hash() const {
    const auto found = content_->file.metadata().find("xxh3");
    return found == content_->file.metadata().end() ? std::string() : found->second;
}
const ModelContext& ModelFile::context() const { return content_->context; }
const TrainingState& ModelFile::state() const { return content_->state; }
const CodeTable& ModelFile::codes() const { return content_->codes; }

void ModelFile::load(LearnedModel& model) const {
    as_checkpoint(path(), [&] {
        model.load(content_->file);
        if (codes().code_count == model.code_count()) return;
        throw CheckpointError(path(), fmt::format("{} codes of a shape, the model has {}",
                                                  codes().code_count, model.code_count()));
    });
}

}  // namespace mscomp
