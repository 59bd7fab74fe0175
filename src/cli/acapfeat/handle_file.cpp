// SPDX-License-Identifier: MIT
#include "handle_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/json_text.h"

namespace mscomp {
namespace {

constexpr double kLargest = 1e30;  // far within float32, which meshes and features are stored in

class HandleReader {
  public:
    HandleReader(const std::string& path, int vertex_count)
        : path_(path), vertex_count_(vertex_count) {}

    std::vector<Handle> read() {
        const auto file =
            parsed_json<nlohmann::json>(read_text_file(path_, "a list of handles"), path_);
        if (!file.is_object() || !file.contains("handles") || !file["handles"].is_array()) {
            throw InputError({path_}, "wanted an object with a list 'handles'");
        }
        for (const auto& [key, value] : file.items()) {
            if (key != "handles") {
                throw InputError({path_}, fmt::format("unknown key '{}', wanted handles", key));
            }
        }
        std::vector<Handle> handles;
        for (const nlohmann::json& entry : file["handles"]) {
            const Handle handle = read_one(entry);
            const auto same = std::ranges::find(handles, handle.vertex, &Handle::vertex);
            if (same != handles.end()) {
                fail(fmt::format("vertex {} has handles[{}] already, wanted one handle a vertex",
                                 handle.vertex, same - handles.begin()));
            }
            handles.push_back(handle);
            ++index_;
        }
        if (handles.empty()) throw InputError({path_}, "names no handle, wanted at least one");
        return handles;
    }

  private:
    Handle read_one(const nlohmann::json& entry) const {
        if (!entry.is_object()) fail("wanted an object with 'vertex' and 'position'");
        for (const auto& [key, value] : entry.items()) {
            if (key == "vertex" || key == "position" || key == "weight") continue;
            fail(fmt::format("unknown key '{}', wanted vertex, position or weight", key));
        }
        Handle handle;
        const nlohmann::json vertex = entry.value("vertex", nlohmann::json());
        if (!vertex.is_number_integer() || vertex < 0 || vertex >= vertex_count_) {
            fail(fmt::format("'vertex' is {}, wanted 0 to {}", json_text(vertex),
                             vertex_count_ - 1));
        }
        handle.vertex = vertex.get<int>();
        const nlohmann::json position = entry.value("position", nlohmann::json());
        if (!position.is_array() || position.size() != 3) {
            fail(fmt::format("'position' is {}, wanted three numbers", json_text(position)));
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!position[axis].is_number()) {
                fail(fmt::format("'position' is {}, wanted three numbers", json_text(position)));
            }
            handle.position[axis] = position[axis].get<double>();
            if (!(std::abs(handle.position[axis]) <= kLargest)) {
                fail(fmt::format("'position' is {}, wanted numbers up to {:g}", json_text(position),
                                 kLargest));
            }
        }
        if (entry.contains("weight")) {
            const nlohmann::json& weight = entry["weight"];
            if (!weight.is_number() || !(weight.get<double>() > 0)) {
                fail(fmt::format("'weight' is {}, wanted a positive number", json_text(weight)));
            }
            handle.weight = weight.get<double>();
        }
        return handle;
    }

    [[noreturn]] void fail(std::string_view message) const {
        throw InputError({path_}, fmt::format("handles[{}]: {}", index_, message));
    }

    const std::string& path_;
    int vertex_count_;
    std::size_t index_ = 0;
};

}  // namespace

std::vector<Handle> read_handles(const std::string& path, int vertex_count) {
    return HandleReader(path, vertex_count).read();
}

}  // namespace mscomp
