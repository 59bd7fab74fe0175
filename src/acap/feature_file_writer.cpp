// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "feature_format.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/finite.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/safetensors_pieces.h"

namespace mscomp {
namespace {

using Json = nlohmann::json;
using Tensors = std::vector<SafetensorsPieceWriter::Tensor>;

/// Warnings are known when all rows are written, behind the header that holds them.
constexpr std::size_t kWarningBytes = 64 * 1024;

Tensors tensors_of(const FeatureSet& outline, const VertexPlaces& places) {
    const std::int64_t count = outline.shape_count(), vertices = outline.vertex_count();
    Tensors tensors{{"features", DataType::f32, {count, vertices, kFeatureDim}},
                    {"vertices", DataType::f32, {count, vertices, 3}},
                    {"reference", DataType::f64, {vertices, 3}},
                    {"rotation", DataType::f64, {count, 3, 3}},
                    {"translation", DataType::f64, {count, 3}},
                    {"faces", DataType::i32, {outline.reference.face_count(), 3}}};
    if (!places.are_all_vertices()) tensors.push_back({"place", DataType::i32, {vertices}});
    for (const PerShapeNumber& number : kPerShapeNumbers) {
        if ((outline.*number.member).empty()) continue;
        tensors.push_back({number.name, DataType::f64, {count}});
    }
    return tensors;
}

std::string json_list(const std::vector<std::string>& texts) { return json_text(Json(texts)); }

Metadata metadata_of(const FeatureSet& outline) {
    return {{"format_version", kFeatureFormatVersion},
            {"layout", kFeatureLayout},
            {"weights", outline.weights},
            {"source", "acapfeat extract"},
            {"names", json_list(outline.names)}};
}

}  // namespace

struct FeatureFileWriter::State {
    State(const std::string& file, const FeatureSet& outline, const VertexPlaces& places)
        : path(file),
          count(outline.shape_count()),
          vertex_count(outline.vertex_count()),
          writer(file, tensors_of(outline, places), metadata_of(outline), kWarningBytes) {}

    /// All of a tensor, or the row of one shape.
    template <class T>
    void write(const std::string& name, std::int64_t first, std::span<const T> data,
               const Shape& shape, bool may_be_nan = false) {
        const std::span<const std::byte> bytes = std::as_bytes(data);
        if (const auto place = first_non_finite<T>(bytes, first, shape, may_be_nan)) {
            throw NumericalError(fmt::format("{}: {}{}; nothing was written", path, name, *place));
        }
        writer.write(name, first, data);
    }
    template <class T>
    void write_all(const std::string& name, std::span<const T> data, const Shape& shape,
                   bool may_be_nan = false) {
        std::int64_t wanted = 1;
        for (const std::int64_t length : shape) wanted *= length;
        if (static_cast<std::int64_t>(data.size()) != wanted) {
            throw std::logic_error(
                fmt::format("{} numbers in {}, wanted {}", data.size(), name, wanted));
        }
        write(name, 0, data, shape, may_be_nan);
    }
    void write_row(const std::string& name, int shape, std::span<const float> row, int width) {
        check_width(name, row.size(), width);
        write(name, first_of(shape, width), row, {count, vertex_count, width});
    }
    void check_width(const std::string& name, std::size_t size, int width) const {
        if (static_cast<std::int64_t>(size) == vertex_count * width) return;
        throw std::logic_error(fmt::format("a row of {} numbers in {}", size, name));
    }
    std::int64_t first_of(int shape, int width) const { return shape * vertex_count * width; }

    /// All warnings, or as many as there is room for and the number of the others.
    Metadata warnings_that_fit(const std::vector<std::string>& warnings) const {
        Metadata all{{"warnings", json_list(warnings)}};
        if (writer.has_room_for(all)) return all;
        Metadata best;
        for (std::size_t low = 0, high = warnings.size(); low < high;) {
            const std::size_t kept = low + (high - low) / 2;
            std::vector<std::string> shortened(
                warnings.begin(), warnings.begin() + static_cast<std::ptrdiff_t>(kept));
            shortened.push_back(fmt::format("{} further warnings did not fit into the file",
                                            warnings.size() - kept));
            Metadata metadata{{"warnings", json_list(shortened)}};
            if (writer.has_room_for(metadata)) {
                best = std::move(metadata);
                low = kept + 1;
            } else {
                high = kept;
            }
        }
        return best;
    }

    std::string path;
    std::int64_t count, vertex_count;
    SafetensorsPieceWriter writer;
};

FeatureFileWriter::FeatureFileWriter(const std::string& path, const FeatureSet& outline,
                                     const VertexPlaces& places)
    : state_(std::make_unique<State>(path, outline, places)) {
    state_->write_all("reference", flat(outline.reference.vertices), {state_->vertex_count, 3});
    state_->writer.write("faces", 0, flat(outline.reference.faces));
    if (places.are_all_vertices()) return;
    state_->writer.write("place", 0, std::span<const int>(places.place_of_vertex()));
}
FeatureFileWriter::~FeatureFileWriter() = default;

void FeatureFileWriter::put_vertices(int shape, std::span<const float> row) {
    state_->write_row("vertices", shape, row, 3);
}
void FeatureFileWriter::put_features(int shape, std::span<const float> row) {
    state_->write_row("features", shape, row, kFeatureDim);
}
void FeatureFileWriter::get_features(int shape, std::span<float> row) const {
    state_->check_width("features", row.size(), kFeatureDim);
    state_->writer.read("features", state_->first_of(shape, kFeatureDim), row);
}

void FeatureFileWriter::finish(const FeatureSet& set) {
    state_->write_all("rotation", flat(set.rotation), {state_->count, 3, 3});
    state_->write_all("translation", flat(set.translation), {state_->count, 3});
    for (const PerShapeNumber& number : kPerShapeNumbers) {
        const std::vector<double>& data = set.*number.member;
        if (data.empty()) continue;
        state_->write_all(number.name, std::span<const double>(data), {state_->count},
                          number.may_be_nan);
    }
    state_->writer.finish(state_->warnings_that_fit(set.warnings));
}

void write_features(const std::string& path, const FeatureSet& set, const VertexPlaces& places) {
    const auto wanted = at(set.shape_count()) * set.reference.vertices.size();
    if (set.features.size() != wanted * kFeatureDim || set.vertices.size() != wanted * 3) {
        throw std::logic_error("features or vertices of another size than names and reference say");
    }
    FeatureFileWriter writer(path, set, places);
    const std::span<const float> vertices(set.vertices);
    const std::size_t width = set.reference.vertices.size() * 3;
    for (int n = 0; n < set.shape_count(); ++n) {
        writer.put_features(n, set.shape(n));
        writer.put_vertices(n, vertices.subspan(at(n) * width, width));
    }
    writer.finish(set);
}

}  // namespace mscomp
