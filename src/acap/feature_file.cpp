// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "feature_format.h"
#include "mscomp/base/error.h"
#include "mscomp/base/finite.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using Json = nlohmann::json;

[[noreturn]] void fail(const std::string& path, std::string_view message) {
    throw InputError({path}, message);
}

/// Refuses numbers that are not finite in the tensors that are used.
void check_finite(const std::string& path, const SafetensorsPiece& piece) {
    const auto per_shape =
        std::find_if(kPerShapeNumbers.begin(), kPerShapeNumbers.end(),
                     [&](const auto& known) { return known.name == piece.name; });
    const bool is_per_shape = per_shape != kPerShapeNumbers.end();
    constexpr std::array<std::string_view, 5> kRequired{"features", "vertices", "reference",
                                                        "rotation", "translation"};
    if (!is_per_shape &&
        std::find(kRequired.begin(), kRequired.end(), piece.name) == kRequired.end()) {
        return;
    }
    const auto place = first_non_finite(piece, is_per_shape && per_shape->may_be_nan);
    if (place) fail(path, fmt::format("{}{}, wanted a finite number", piece.name, *place));
}

/// Everything but the rows.
class OutlineReader {
  public:
    explicit OutlineReader(const SafetensorsFile& file) : file_(file) {}

    PlacedFeatures read() {
        check_metadata();
        file_.data<float>("features", {-1, -1, kFeatureDim});
        count_ = file_.shape("features")[0];
        vertex_count_ = file_.shape("features")[1];
        constexpr std::int64_t kMost = std::numeric_limits<int>::max();
        if (count_ == 0 || vertex_count_ == 0 || count_ > kMost || vertex_count_ > kMost) {
            fail(fmt::format("features of {} shapes with {} vertices, wanted at least one of each",
                             count_, vertex_count_));
        }
        file_.data<float>("vertices", {count_, vertex_count_, 3});
        PlacedFeatures set;
        set.reference.vertices =
            rows_of<double, 3>(file_.data<double>("reference", {vertex_count_, 3}));
        set.reference.faces = read_faces();
        set.places = read_places(set.reference);
        set.rotation = rows_of<double, 9>(file_.data<double>("rotation", {count_, 3, 3}));
        set.translation = rows_of<double, 3>(file_.data<double>("translation", {count_, 3}));
        for (const PerShapeNumber& number : kPerShapeNumbers) {
            if (!file_.contains(number.name)) continue;
            const std::span<const double> data = file_.data<double>(number.name, {count_});
            (set.*number.member).assign(data.begin(), data.end());
        }
        set.weights = metadata("weights").value_or("cotangent");
        set.names = read_names();
        set.warnings = read_list("warnings").value_or(std::vector<std::string>{});
        return set;
    }

  private:
    void check_metadata() const {
        const std::string version = metadata("format_version").value_or(kFeatureFormatVersion);
        if (version != kFeatureFormatVersion) {
            fail(fmt::format("format version '{}', this program reads '{}'", version,
                             kFeatureFormatVersion));
        }
        const std::string layout = metadata("layout").value_or(kFeatureLayout);
        if (layout != kFeatureLayout) {
            fail(fmt::format("features in the layout '{}', wanted '{}'", layout, kFeatureLayout));
        }
        const std::string weights = metadata("weights").value_or("cotangent");
        if (weights != "cotangent" && weights != "authors" && weights != "uniform") {
            fail(
                fmt::format("features made with the weights '{}', wanted cotangent, authors or "
                            "uniform",
                            weights));
        }
    }

    std::vector<Face> read_faces() const {
        std::vector<Face> faces = rows_of<int, 3>(file_.data<int>("faces", {-1, 3}));
        if (faces.empty()) fail("has no faces");
        for (std::size_t i = 0; i < faces.size(); ++i) {
            for (const int corner : faces[i]) {
                if (corner >= 0 && corner < vertex_count_) continue;
                fail(fmt::format("faces[{}] refers to vertex {}, the file has 0 to {}", i, corner,
                                 vertex_count_ - 1));
            }
        }
        return faces;
    }

    /// Files of other programs do not say which vertices coincide, but which are in no face.
    VertexPlaces read_places(const TriangleMesh& reference) const {
        if (!file_.contains("place")) {
            std::vector<int> own(reference.vertices.size());
            std::iota(own.begin(), own.end(), 0);
            return {own, reference.faces};
        }
        const std::span<const int> place = file_.data<int>("place", {vertex_count_});
        try {
            return VertexPlaces::from_stored({place.begin(), place.end()}, reference.faces);
        } catch (const MeshError& error) {
            fail(error.what());
        }
    }

    std::vector<std::string> read_names() const {
        if (auto names = read_list("names")) {
            if (static_cast<std::int64_t>(names->size()) == count_) return std::move(*names);
            fail(fmt::format("{} names for {} shapes", names->size(), count_));
        }
        std::vector<std::string> names;
        for (std::int64_t i = 0; i < count_; ++i) names.push_back(fmt::format("shape_{:04}", i));
        return names;
    }

    std::optional<std::vector<std::string>> read_list(const std::string& key) const {
        const std::optional<std::string> text = metadata(key);
        if (!text) return std::nullopt;
        const std::optional<Json> list = sound_json<Json>(*text);
        const bool strings =
            list && list->is_array() &&
            std::all_of(list->begin(), list->end(), [](const Json& x) { return x.is_string(); });
        if (!strings) fail(fmt::format("metadata '{}' is not a JSON list of strings", key));
        return list->get<std::vector<std::string>>();
    }

    std::optional<std::string> metadata(const std::string& key) const {
        const auto found = file_.metadata().find(key);
        if (found == file_.metadata().end()) return std::nullopt;
        return found->second;
    }

    [[noreturn]] void fail(std::string_view message) const { mscomp::fail(file_.path(), message); }

    const SafetensorsFile& file_;
    std::int64_t count_ = 0;
    std::int64_t vertex_count_ = 0;
};

}  // namespace

struct FeatureFile::State {
    explicit State(const std::string& path)
        : file(path, [&path](const SafetensorsPiece& piece) { check_finite(path, piece); }),
          outline(OutlineReader(file).read()),
          features(file.data<float>("features", {-1, -1, kFeatureDim})),
          vertices(file.data<float>("vertices", {-1, -1, 3})) {}

    std::span<const float> row(std::span<const float> all, int index) const {
        const std::size_t width = all.size() / outline.names.size();
        return all.subspan(at(index) * width, width);
    }
    /// The system brings in what lies around a page that is used, too. Were that left, reading
    /// shapes in any order but their own would fill the memory.
    void forget_around(std::span<const float> all, int index) const {
        constexpr std::size_t kAround = 65536 / sizeof(float);
        const std::size_t width = all.size() / outline.names.size();
        const std::size_t begin = at(index) * width;
        const std::size_t first = begin - std::min(begin, kAround);
        const std::size_t end = std::min(all.size(), begin + width + kAround);
        file.forget(std::as_bytes(all.subspan(first, end - first)));
    }

    SafetensorsFile file;
    PlacedFeatures outline;
    std::span<const float> features, vertices;
};

FeatureFile::FeatureFile(const std::string& path) : state_(std::make_unique<State>(path)) {}
FeatureFile::FeatureFile(FeatureFile&&) noexcept = default;
FeatureFile& FeatureFile::operator=(FeatureFile&&) noexcept = default;
FeatureFile::~FeatureFile() = default;

const std::string& FeatureFile::path() const { return state_->file.path(); }
const PlacedFeatures& FeatureFile::outline() const { return state_->outline; }
std::string FeatureFile::data_hash() const {
    const auto found = state_->file.metadata().find("xxh3");
    return found == state_->file.metadata().end() ? std::string() : found->second;
}
std::span<const float> FeatureFile::shape(int index) const {
    return state_->row(state_->features, index);
}
std::span<const float> FeatureFile::vertices(int index) const {
    return state_->row(state_->vertices, index);
}

void FeatureFile::forget(int index) const {
    state_->forget_around(state_->features, index);
    state_->forget_around(state_->vertices, index);
}

PlacedFeatures read_features(const std::string& path) {
    const FeatureFile file(path);
    PlacedFeatures set = file.outline();
    const auto count = at(file.shape_count());
    set.features.reserve(count * file.shape(0).size());
    set.vertices.reserve(count * file.vertices(0).size());
    for (int n = 0; n < file.shape_count(); ++n) {
        const std::span<const float> features = file.shape(n), vertices = file.vertices(n);
        set.features.insert(set.features.end(), features.begin(), features.end());
        set.vertices.insert(set.vertices.end(), vertices.begin(), vertices.end());
        file.forget(n);
    }
    return set;
}

}  // namespace mscomp
