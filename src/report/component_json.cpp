// SPDX-License-Identifier: MIT
#include "component_json.h"

#include <nlohmann/json.hpp>
#include <string>

namespace mscomp {
namespace {

nlohmann::ordered_json text_or_null(const std::string& text) {
    return text.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(text);
}

}  // namespace

nlohmann::ordered_json component_json(const Component& c, const ModelContext& context) {
    const auto share = [&context](int places) {
        return static_cast<double>(places) / context.reference.vertex_count();
    };
    nlohmann::ordered_json json{{"id", c.id},
                                {"level", c.level},
                                {"parent", text_or_null(c.parent)},
                                {"center_vertex", context.places.vertex(c.center)},
                                {"longest_vertex", context.places.vertex(c.longest)},
                                {"strength", c.strength},
                                {"distance", c.distance},
                                {"kept", c.kept},
                                {"reason", text_or_null(c.reason)},
                                {"merged_into", text_or_null(c.merged_into)},
                                {"cost", c.cost},
                                {"code_min", c.code_min},
                                {"code_max", c.code_max},
                                {"code_reference", c.code_reference},
                                {"code_end", c.code_end},
                                {"code_other", c.code_other},
                                {"support_vertices", c.support},
                                {"support", share(c.support)},
                                {"moving", share(c.moving)},
                                {"localization_radius", c.localization_radius}};
    if (c.trust) {
        json["votes"] = c.trust->votes;
        json["found_again"] = c.trust->found_again;
        json["held_out"] = c.trust->held_out;
    }
    return json;
}

}  // namespace mscomp
