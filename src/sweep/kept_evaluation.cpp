// SPDX-License-Identifier: MIT
#include "kept_evaluation.h"

#include <algorithm>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

using Json = nlohmann::ordered_json;

bool is_component(const Json& entry) {
    if (!entry.is_object()) return false;
    const auto level = entry.find("level"), kept = entry.find("kept"),
               support = entry.find("support");
    return level != entry.end() && level->is_number_unsigned() && kept != entry.end() &&
           kept->is_boolean() && support != entry.end() && support->is_number() && *support >= 0 &&
           *support <= 1;
}

/// Whether measures_of() finds in it what it expects.
bool is_evaluation(const Json& json) {
    if (!json.is_object()) return false;
    const auto list = json.find("component_list");
    if (list == json.end()) return true;
    return list->is_array() && std::ranges::all_of(*list, is_component);
}

}  // namespace

std::optional<Json> kept_evaluation(const std::string& path, const Json& made_from) {
    if (!path_exists(path)) return {};
    std::optional<Json> file = sound_json<Json>(read_file(path));
    if (!file || !file->is_object() || !file->contains("made_from") ||
        file->at("made_from") != made_from || !file->contains("evaluation") ||
        !is_evaluation(file->at("evaluation"))) {
        return {};
    }
    return std::move(file->at("evaluation"));
}

Json keep_evaluation(const std::string& path, const Json& made_from, const Json& evaluation) {
    const Json file{{"made_from", made_from}, {"evaluation", evaluation}};
    const std::string text = json_text(file, 2);
    write_file(path, text + "\n");
    return parsed_json<Json>(text, path)["evaluation"];
}

}  // namespace mscomp
