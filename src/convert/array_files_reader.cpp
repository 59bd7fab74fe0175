// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "array_checks.h"
#include "array_layout.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/printable.h"
#include "mscomp/convert/array_files.h"
#include "mscomp/convert/npy.h"
#include "npz_arrays.h"
#include "per_shape_arrays.h"

namespace mscomp {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

/// The shapes of an array (N,V,3), in the memory of its file.
class ArrayShapes final : public ShapeSource {
  public:
    ArrayShapes(std::unique_ptr<const std::string> file, OwnedArray vertices,
                std::vector<Face> faces, std::vector<std::string> names)
        : file_(std::move(file)),
          vertices_(std::move(vertices)),
          faces_(std::move(faces)),
          names_(std::move(names)) {}

    const std::vector<std::string>& names() const override { return names_; }
    const std::vector<Face>& faces() const override { return faces_; }
    int vertex_count() const override { return static_cast<int>(vertices_.array.shape[1]); }
    std::vector<Point> shape(int index) const override {
        return points_of(vertices_.array.doubles(index, 1));
    }

  private:
    std::unique_ptr<const std::string> file_;
    OwnedArray vertices_;
    std::vector<Face> faces_;
    std::vector<std::string> names_;
};

void require_mesh_counts(const NpyArray& array, std::int64_t last) {
    require_shape(array.shape, {-1, -1, last}, array.path);
    require_counts(array.shape[0], array.shape[1], array.path);
}

/// What is known of V by a mesh that was given.
VertexCount count_of(const Supplement& supplement) {
    VertexCount count;
    if (supplement.reference) count.exact = supplement.reference->vertex_count();
    return count;
}

/// What people call the arrays of shapes, in any case.
constexpr std::array<std::string_view, 10> kVertexNames{
    "vertices", "verts", "vertex", "v", "points", "pts", "positions", "pos", "coords", "xyz"};
constexpr std::array<std::string_view, 8> kFaceNames{"faces", "tris",  "triangles", "face",
                                                     "f",     "cells", "tri",       "triangle"};

class NpzReader {
  public:
    NpzReader(const std::string& path, const Supplement& supplement)
        : path_(path), supplement_(supplement), arrays_(path) {}

    Contents read() {
        Contents contents = arrays_.contains("features") ? read_features() : read_shapes();
        contents.notes.insert(contents.notes.end(), notes_.begin(), notes_.end());
        if (!arrays_.left().empty()) {
            contents.notes.push_back(
                fmt::format("left out of {}: {}", path_, fmt::join(arrays_.left(), ", ")));
        }
        // Names of arrays are whatever the file says.
        for (std::string& note : contents.notes) note = printable(note);
        return contents;
    }

  private:
    Contents read_features() {
        OwnedArray features = arrays_.load("features");
        features.array = vertex_rows(features.array, kFeatureDim, count_of(supplement_), notes_);
        require_mesh_counts(features.array, kFeatureDim);
        count_ = features.array.shape[0];
        vertex_count_ = features.array.shape[1];
        FeatureSet set;
        set.features = features.array.floats(0, count_);
        bool rounded = features.array.type == NpyType::f64;
        if (const auto vertices = load_if_any("vertices", {count_, vertex_count_, 3})) {
            set.vertices = vertices->array.floats(0, count_);
            rounded = rounded || vertices->array.type == NpyType::f64;
        }
        if (const auto reference = load_if_any("reference", {vertex_count_, 3})) {
            set.reference.vertices = points_of(reference->array.doubles(0, vertex_count_));
        }
        if (const auto faces = load_if_any("faces", {-1, 3})) {
            set.reference.faces = checked_faces(faces->array.integers(),
                                                static_cast<int>(vertex_count_), faces->array.path);
        }
        read_motions(set);
        for (const PerShapeArray& array : kPerShapeArrays) {
            if (const auto found = load_if_any(array.name, {count_})) {
                set.*array.numbers = found->array.doubles(0, count_, array.may_be_nan);
            }
        }
        set.names = names_if_any();
        set.weights = weights_if_any();
        if (const auto warnings = load_if_any("warnings", {-1})) {
            set.warnings = warnings->array.texts();
        }
        Contents contents = complete_features(std::move(set), static_cast<int>(count_),
                                              static_cast<int>(vertex_count_), path_, supplement_);
        if (const auto place = load_if_any("place", {vertex_count_})) {
            contents.features->places = checked_places(*place, contents.features->reference.faces);
        }
        if (rounded) contents.notes.emplace_back("features and vertices are rounded to float32");
        return contents;
    }

    static VertexPlaces checked_places(const OwnedArray& place, const std::vector<Face>& faces) {
        try {
            return VertexPlaces::from_stored(place.array.integers(), faces);
        } catch (const MeshError& error) {
            throw InputError({place.array.path}, error.what());
        }
    }

    void read_motions(FeatureSet& set) {
        if (const auto rotation = load_if_any("rotation", {count_, 3, 3})) {
            const std::vector<double> numbers = rotation->array.doubles(0, count_);
            set.rotation.resize(numbers.size() / 9);
            for (std::size_t i = 0; i < numbers.size(); ++i)
                set.rotation[i / 9][i % 9] = numbers[i];
            require_rotations(set, rotation->array.path);
        }
        if (const auto translation = load_if_any("translation", {count_, 3})) {
            set.translation = points_of(translation->array.doubles(0, count_));
        }
    }

    /// Going back to the input takes the transpose for the inverse.
    static void require_rotations(const FeatureSet& set, const std::string& path) {
        for (std::size_t shape = 0; shape < set.rotation.size(); ++shape) {
            const auto& r = set.rotation[shape];
            for (std::size_t i = 0; i < 9; ++i) {
                const std::size_t a = 3 * (i / 3), b = 3 * (i % 3);
                const double product = r[a] * r[b] + r[a + 1] * r[b + 1] + r[a + 2] * r[b + 2];
                if (std::abs(product - (a == b ? 1 : 0)) <= 1e-6) continue;
                throw InputError({path},
                                 fmt::format("the matrix of shape {} is no rotation", shape));
            }
        }
    }

    Contents read_shapes() {
        const std::optional<std::string> vertex_name =
            arrays_.name_among(kVertexNames, &is_vertex_array, notes_);
        const std::optional<std::string> face_name =
            arrays_.name_among(kFaceNames, &is_face_array, notes_);
        if (!vertex_name) {
            throw InputError(
                {path_},
                fmt::format("holds neither 'features' nor 'vertices' or '{}'; "
                            "it holds {}",
                            fmt::join(kVertexNames.begin() + 1, kVertexNames.end(), "', '"),
                            arrays_.list()));
        }
        VertexCount known = count_of(supplement_);
        std::vector<int> corners;
        if (face_name) {
            corners = face_corners(arrays_.load(*face_name).array);
            known = {.least = least_vertices(corners)};
        }
        OwnedArray vertices = arrays_.load(*vertex_name);
        vertices.array = vertex_rows(vertices.array, 3, known, notes_);
        require_mesh_counts(vertices.array, 3);
        count_ = vertices.array.shape[0];
        vertex_count_ = vertices.array.shape[1];
        Contents contents;
        std::vector<Face> faces;
        if (face_name) {
            const auto count = static_cast<int>(vertex_count_);
            count_from_zero(corners, count, notes_);
            faces = checked_faces(corners, count, arrays_.place_of(*face_name));
        } else {
            faces = supplied_faces(contents);
        }
        std::vector<std::string> names = names_if_any();
        if (names.empty()) {
            names = numbered_names(static_cast<int>(count_));
            contents.notes.emplace_back("names are shape_0000, ...");
        }
        contents.shapes = std::make_unique<ArrayShapes>(arrays_.take_file(), std::move(vertices),
                                                        std::move(faces), std::move(names));
        return contents;
    }

    /// Those that corners refer to; they may count from 1.
    static std::int64_t least_vertices(const std::vector<int>& corners) {
        if (corners.empty()) return 1;
        const auto [lowest, highest] = std::minmax_element(corners.begin(), corners.end());
        const std::int64_t count = std::int64_t{*highest} + (*lowest == 0 ? 1 : 0);
        return std::max<std::int64_t>(1, count);
    }

    static bool is_vertex_array(const NpyArray& array) {
        return array.holds_reals() && array.shape.size() == 3 && has_vertex_rows(array, 3, {});
    }
    static bool is_face_array(const NpyArray& array) {
        return array.holds_integers() && array.shape.size() == 2 &&
               (array.shape[0] == 3 || array.shape[1] == 3);
    }

    std::vector<Face> supplied_faces(Contents& contents) const;

    std::vector<std::string> names_if_any() {
        const auto found = load_if_any("names", {count_});
        return found ? found->array.texts() : std::vector<std::string>{};
    }

    std::string weights_if_any() {
        if (!arrays_.contains("weights")) return "";
        const OwnedArray found = arrays_.load("weights");
        // Some functions of numpy make a list of one out of a single entry.
        if (!found.array.shape.empty()) require_shape(found.array.shape, {1}, found.array.path);
        std::string name = found.array.texts().front();
        for (const EdgeWeights known :
             {EdgeWeights::cotangent, EdgeWeights::authors, EdgeWeights::uniform}) {
            if (name == to_string(known)) return name;
        }
        throw InputError({found.array.path}, fmt::format("got '{}', wanted cotangent, authors or "
                                                         "uniform",
                                                         name));
    }

    std::optional<OwnedArray> load_if_any(const std::string& name, const Shape& shape) {
        if (!arrays_.contains(name)) return std::nullopt;
        OwnedArray found = arrays_.load(name);
        require_shape(found.array.shape, shape, found.array.path);
        return found;
    }

    const std::string& path_;
    const Supplement& supplement_;
    NpzArrays arrays_;
    std::vector<std::string> notes_;  // how arrays were read
    std::int64_t count_ = 0, vertex_count_ = 0;
};

/// The faces of the reference, for shapes that come without.
std::vector<Face> supply_faces(Contents& contents, const std::string& path,
                               std::int64_t vertex_count, const Supplement& supplement) {
    if (!supplement.reference) {
        throw UsageError(path + " has no faces; give a mesh that has them: --reference MESH");
    }
    if (supplement.reference->vertex_count() != vertex_count) {
        throw InputError({supplement.reference_path},
                         fmt::format("{} vertices, but {} has {}",
                                     supplement.reference->vertex_count(), path, vertex_count));
    }
    contents.took_reference = true;
    contents.notes.push_back("faces are those of " + supplement.reference_path);
    return supplement.reference->faces;
}

std::vector<Face> NpzReader::supplied_faces(Contents& contents) const {
    return supply_faces(contents, path_, vertex_count_, supplement_);
}

}  // namespace

Contents read_npz(const std::string& path, const Supplement& supplement) {
    return NpzReader(path, supplement).read();
}

Contents read_npy(const std::string& path, const Supplement& supplement) {
    auto file = std::make_unique<const std::string>(read_file(path));
    OwnedArray owned;
    owned.array = parse_npy(bytes_of(*file), path);
    NpyArray& array = owned.array;
    const VertexCount known = count_of(supplement);
    std::vector<std::string> notes;
    const bool has_features = array.shape.size() == 3 && array.shape[2] == kFeatureDim;
    if (has_features ||
        (!has_vertex_rows(array, 3, known) && has_vertex_rows(array, kFeatureDim, known))) {
        array = vertex_rows(array, kFeatureDim, known, notes);
        require_mesh_counts(array, kFeatureDim);
        FeatureSet set;
        set.features = array.floats(0, array.shape[0]);
        set.weights.clear();
        Contents contents = complete_features(std::move(set), static_cast<int>(array.shape[0]),
                                              static_cast<int>(array.shape[1]), path, supplement);
        contents.notes.insert(contents.notes.end(), notes.begin(), notes.end());
        if (array.type == NpyType::f64) {
            contents.notes.emplace_back("features are rounded to float32");
        }
        return contents;
    }
    array = vertex_rows(array, 3, known, notes);
    require_mesh_counts(array, 3);
    Contents contents;
    contents.notes = std::move(notes);
    std::vector<Face> faces = supply_faces(contents, path, array.shape[1], supplement);
    std::vector<std::string> names = numbered_names(static_cast<int>(array.shape[0]));
    contents.notes.emplace_back("names are shape_0000, ...");
    contents.shapes = std::make_unique<ArrayShapes>(std::move(file), std::move(owned),
                                                    std::move(faces), std::move(names));
    return contents;
}

}  // namespace mscomp
