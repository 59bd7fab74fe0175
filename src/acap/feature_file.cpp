// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormatVersion = "1";
constexpr const char* kLayout = "rx ry rz s11 s12 s13 s22 s23 s33";

/// "[2, 17, 4] is nan" for the first value that is not finite.
template <class T>
std::optional<std::string> first_non_finite(std::span<const T> values, const Shape& shape) {
    const auto found =
        std::find_if(values.begin(), values.end(), [](T x) { return !std::isfinite(x); });
    if (found == values.end()) return std::nullopt;
    auto rest = static_cast<std::int64_t>(found - values.begin());
    std::string index;
    for (std::size_t axis = shape.size(); axis-- > 0;) {
        index = fmt::format("{}{}{}", rest % shape[axis], index.empty() ? "" : ", ", index);
        rest /= shape[axis];
    }
    return fmt::format("[{}] is {}", index, static_cast<double>(*found));
}

/// The numbers of a vector of fixed-size arrays, one after the other.
template <class T, std::size_t kSize>
std::span<const T> flat(const std::vector<std::array<T, kSize>>& rows) {
    static_assert(sizeof(std::array<T, kSize>) == kSize * sizeof(T));
    return {reinterpret_cast<const T*>(rows.data()), rows.size() * kSize};
}

template <class T, std::size_t kSize>
std::vector<std::array<T, kSize>> rows_of(std::span<const T> numbers) {
    std::vector<std::array<T, kSize>> rows(numbers.size() / kSize);
    if (!rows.empty()) std::memcpy(rows.data(), numbers.data(), numbers.size_bytes());
    return rows;
}

std::string json_list(const std::vector<std::string>& texts) {
    // File names need not be UTF-8, JSON must be.
    return Json(texts).dump(-1, ' ', false, Json::error_handler_t::replace);
}

class FeatureWriter {
  public:
    explicit FeatureWriter(const std::string& path) : path_(path) {}

    template <class T>
    void add_finite(const std::string& name, Shape shape, std::span<const T> data) {
        writer_.add(name, shape, data);
        if (const auto place = first_non_finite(data, shape)) {
            throw NumericalError(fmt::format("{}: {}{}; nothing was written", path_, name, *place));
        }
    }
    void add_if_any(const std::string& name, std::int64_t count, const std::vector<double>& data) {
        if (!data.empty()) add_finite(name, {count}, std::span<const double>(data));
    }
    SafetensorsWriter& raw() { return writer_; }
    void write() const { writer_.write(path_); }

  private:
    std::string path_;
    SafetensorsWriter writer_;
};

class FeatureReader {
  public:
    explicit FeatureReader(const std::string& path) : file_(path) {}

    FeatureSet read() {
        check_metadata();
        const Shape& shape = file_.shape("features");
        const auto features = finite<float>("features", {-1, -1, kFeatureDim});
        count_ = shape[0];
        vertex_count_ = shape[1];
        if (count_ == 0 || vertex_count_ == 0 || vertex_count_ > std::numeric_limits<int>::max()) {
            fail(fmt::format("features of {} shapes with {} vertices, wanted at least one of each",
                             count_, vertex_count_));
        }
        const auto vertices = finite<float>("vertices", {count_, vertex_count_, 3});
        FeatureSet set;
        set.features.assign(features.begin(), features.end());
        set.vertices.assign(vertices.begin(), vertices.end());
        set.reference.vertices =
            rows_of<double, 3>(finite<double>("reference", {vertex_count_, 3}));
        set.reference.faces = read_faces();
        set.rotation = rows_of<double, 9>(finite<double>("rotation", {count_, 3, 3}));
        set.translation = rows_of<double, 3>(finite<double>("translation", {count_, 3}));
        set.consistency_energy = read_per_shape("consistency_energy");
        set.consistency_gap = read_per_shape("consistency_gap");
        set.largest_jump = read_per_shape("largest_jump");
        set.weights = metadata("weights").value_or("cotangent");
        set.names = read_names();
        set.warnings = read_list("warnings").value_or(std::vector<std::string>{});
        return set;
    }

  private:
    void check_metadata() const {
        const std::string version = metadata("format_version").value_or(kFormatVersion);
        if (version != kFormatVersion) {
            fail(fmt::format("format version '{}', this program reads '{}'", version,
                             kFormatVersion));
        }
        const std::string layout = metadata("layout").value_or(kLayout);
        if (layout != kLayout) {
            fail(fmt::format("features in the layout '{}', wanted '{}'", layout, kLayout));
        }
        const std::string weights = metadata("weights").value_or("cotangent");
        if (weights != "cotangent" && weights != "authors" && weights != "uniform") {
            fail(
                fmt::format("features made with the weights '{}', wanted cotangent, authors or "
                            "uniform",
                            weights));
        }
    }

    template <class T>
    std::span<const T> finite(const std::string& name, const Shape& shape) const {
        const std::span<const T> data = file_.data<T>(name, shape);
        if (const auto place = first_non_finite(data, file_.shape(name))) {
            fail(fmt::format("{}{}, wanted a finite number", name, *place));
        }
        return data;
    }

    std::vector<double> read_per_shape(const std::string& name) const {
        if (!file_.contains(name)) return {};
        const auto data = finite<double>(name, {count_});
        return {data.begin(), data.end()};
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
        const Json list = Json::parse(*text, nullptr, false);
        const bool strings =
            list.is_array() &&
            std::all_of(list.begin(), list.end(), [](const Json& x) { return x.is_string(); });
        if (!strings) fail(fmt::format("metadata '{}' is not a JSON list of strings", key));
        return list.get<std::vector<std::string>>();
    }

    std::optional<std::string> metadata(const std::string& key) const {
        const auto found = file_.metadata().find(key);
        if (found == file_.metadata().end()) return std::nullopt;
        return found->second;
    }

    [[noreturn]] void fail(std::string_view message) const {
        throw InputError({file_.path()}, message);
    }

    SafetensorsFile file_;
    std::int64_t count_ = 0;
    std::int64_t vertex_count_ = 0;
};

}  // namespace

void write_features(const std::string& path, const FeatureSet& set) {
    const std::int64_t count = set.shape_count(), vertices = set.vertex_count();
    FeatureWriter writer(path);
    writer.add_finite("features", {count, vertices, kFeatureDim},
                      std::span<const float>(set.features));
    writer.add_finite("vertices", {count, vertices, 3}, std::span<const float>(set.vertices));
    writer.add_finite("reference", {vertices, 3}, flat(set.reference.vertices));
    writer.add_finite("rotation", {count, 3, 3}, flat(set.rotation));
    writer.add_finite("translation", {count, 3}, flat(set.translation));
    writer.raw().add("faces", {set.reference.face_count(), 3}, flat(set.reference.faces));
    writer.add_if_any("consistency_energy", count, set.consistency_energy);
    writer.add_if_any("consistency_gap", count, set.consistency_gap);
    writer.add_if_any("largest_jump", count, set.largest_jump);
    writer.raw().set_metadata("format_version", kFormatVersion);
    writer.raw().set_metadata("layout", kLayout);
    writer.raw().set_metadata("weights", set.weights);
    writer.raw().set_metadata("source", "acapfeat extract");
    writer.raw().set_metadata("names", json_list(set.names));
    writer.raw().set_metadata("warnings", json_list(set.warnings));
    writer.write();
}

FeatureSet read_features(const std::string& path) { return FeatureReader(path).read(); }

}  // namespace mscomp
