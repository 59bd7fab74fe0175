// SPDX-License-Identifier: MIT
#include "component_report.h"

#include <algorithm>
#include <span>
#include <string>

#include "component_json.h"
#include "mscomp/base/index.h"
#include "mscomp/eval/component_statistics.h"

namespace mscomp {
namespace {

nlohmann::ordered_json cosine_json(const std::vector<Component>& components) {
    std::vector<std::span<const float>> differences;
    std::vector<std::string> ids;
    for (const Component& c : components) {
        if (!c.kept) continue;
        differences.emplace_back(c.difference);
        ids.push_back(c.id);
    }
    const ComponentCosines alike = component_cosines(differences);
    nlohmann::ordered_json matrix = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const auto row = alike.cosine.begin() + static_cast<std::ptrdiff_t>(k * ids.size());
        matrix.push_back(std::vector<double>(row, row + static_cast<std::ptrdiff_t>(ids.size())));
    }
    nlohmann::ordered_json mean = nullptr, max = nullptr;
    if (ids.size() > 1) {
        mean = alike.cosine_mean;
        max = alike.cosine_max;
    }
    return {{"mean", mean}, {"max", max}, {"ids", ids}, {"matrix", matrix}};
}

}  // namespace

ComponentReport component_report(const std::vector<Component>& components, int level_count,
                                 const ModelContext& context) {
    ComponentReport report;
    report.list = nlohmann::ordered_json::array();
    std::vector<int> kept(at(level_count), 0);
    for (const Component& c : components) {
        report.list.push_back(component_json(c, context));
        if (c.kept) ++kept[at(c.level)];
    }
    if (std::ranges::any_of(components, &Component::kept)) {
        report.support_mean = mean_support_of_kept(components, context.reference.vertex_count());
    }
    report.kept_per_level = kept;
    report.cosine = cosine_json(components);
    return report;
}

}  // namespace mscomp
