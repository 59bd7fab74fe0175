// SPDX-License-Identifier: MIT
#include "true_components.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {
namespace {

using nlohmann::json;

class TruthReader {
  public:
    explicit TruthReader(const std::string& path) : path_(path) {}

    TrueComponents read() const {
        const auto file =
            parsed_json<json>(read_text_file(path_, "the truth of a generated set"), path_);
        TrueComponents truth;
        truth.names = strings(list(file, "names"), "names");
        truth.frames = strings(list(file, "frames"), "frames");
        const json& scales = list(file, "scales");
        require_count("scales", scales.size(), truth.names.size());
        for (std::size_t u = 0; u < scales.size(); ++u) {
            if (!scales[u].is_number_integer() || scales[u] < 0 || scales[u] > 1) {
                fail(fmt::format("scales[{}] is {}, wanted 0 (coarse) or 1 (fine)", u,
                                 shown(scales[u])));
            }
            truth.scales.push_back(scales[u].get<int>());
        }
        const json& weights = list(file, "weights");
        require_count("weights", weights.size(), truth.frames.size());
        for (std::size_t n = 0; n < weights.size(); ++n) {
            add_weights(weights[n], n, truth);
        }
        return truth;
    }

  private:
    const json& list(const json& file, const char* key) const {
        if (!file.is_object() || !file.contains(key) || !file[key].is_array() ||
            file[key].empty()) {
            fail(
                fmt::format("wanted an object with the lists names, scales, frames and weights; "
                            "{} is missing, empty or no list",
                            key));
        }
        return file[key];
    }
    std::vector<std::string> strings(const json& list, const char* key) const {
        std::vector<std::string> result;
        std::set<std::string_view> earlier;
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (!list[i].is_string()) {
                fail(fmt::format("{}[{}] is {}, wanted a name", key, i, shown(list[i])));
            }
            if (!earlier.insert(list[i].get_ref<const std::string&>()).second) {
                fail(fmt::format("{}[{}] is {}, which stands before it already", key, i,
                                 shown(list[i])));
            }
            result.push_back(list[i].get<std::string>());
        }
        return result;
    }
    void add_weights(const json& row, std::size_t n, TrueComponents& truth) const {
        if (!row.is_array() || row.size() != truth.names.size()) {
            fail(fmt::format("weights[{}] is {}, wanted a list of {} numbers", n, shown(row),
                             truth.names.size()));
        }
        for (const json& weight : row) {
            if (!weight.is_number()) {
                fail(fmt::format("weights[{}] is {}, wanted a list of {} numbers", n, shown(row),
                                 truth.names.size()));
            }
            truth.weights.push_back(weight.get<double>());
        }
    }
    void require_count(const char* key, std::size_t got, std::size_t wanted) const {
        if (got == wanted) return;
        fail(fmt::format("{}: {} entries, wanted {}", key, got, wanted));
    }
    /// What stands there, if it is not long.
    static std::string shown(const json& value) {
        constexpr std::size_t kMostShown = 60;
        if (value.is_structured() && value.size() > kMostShown / 3) return value.type_name();
        std::string text = json_text(value);
        return text.size() <= kMostShown ? text : std::string("a long ") + value.type_name();
    }
    [[noreturn]] void fail(std::string_view message) const { throw InputError({path_}, message); }

    const std::string& path_;
};

}  // namespace

TrueComponents read_true_components(const std::string& path) { return TruthReader(path).read(); }

std::vector<double> weights_of_shapes(const TrueComponents& truth, const std::string& path,
                                      const std::vector<std::string>& names,
                                      const std::string& features) {
    std::map<std::string_view, std::size_t> frame_of;
    for (std::size_t n = 0; n < truth.frames.size(); ++n) frame_of.emplace(truth.frames[n], n);
    std::vector<double> weights;
    weights.reserve(names.size() * truth.names.size());
    for (const std::string& name : names) {
        const auto frame = frame_of.find(name);
        if (frame == frame_of.end()) {
            throw InputError({path}, fmt::format("names no frame '{}', a shape of {}; wanted the "
                                                 "truth of these shapes",
                                                 name, features));
        }
        const auto row =
            truth.weights.begin() + static_cast<std::ptrdiff_t>(frame->second * truth.names.size());
        weights.insert(weights.end(), row, row + truth.count());
    }
    return weights;
}

std::string true_supports_path(const std::string& truth_path) {
    constexpr std::string_view kExtension = ".json";
    std::string stem = truth_path;
    if (stem.ends_with(kExtension)) stem.resize(stem.size() - kExtension.size());
    return stem + "_supports.safetensors";
}

std::vector<float> read_true_supports(const std::string& path,
                                      const std::vector<std::string>& names, int vertex_count) {
    const SafetensorsFile file(path);
    const auto text = file.metadata().find("names");
    if (text != file.metadata().end() && sound_json<json>(text->second) != json(names)) {
        throw InputError({path}, "holds supports of other components than the truth names");
    }
    const auto count = static_cast<std::int64_t>(names.size());
    const std::span<const float> supports = file.data<float>("supports", {count, vertex_count});
    for (std::size_t i = 0; i < supports.size(); ++i) {
        if (supports[i] >= 0 && supports[i] <= 1) continue;
        throw InputError({path},
                         fmt::format("supports[{}, {}] is {}, wanted 0 to 1", i / at(vertex_count),
                                     i % at(vertex_count), static_cast<double>(supports[i])));
    }
    return {supports.begin(), supports.end()};
}

}  // namespace mscomp
