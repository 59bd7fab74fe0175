// SPDX-License-Identifier: MIT
#include "component_report.h"

#include <span>
#include <string>

#include "mscomp/base/index.h"
#include "mscomp/eval/component_statistics.h"

namespace mscomp {
namespace {

nlohmann::ordered_json cosine_json(const std::vector<nn::Component>& components,
                                   DistanceRows& distances) {
    std::vector<std::span<const float>> differences;
    std::vector<int> centers;
    std::vector<std::string> ids;
    for (const nn::Component& c : components) {
        if (!c.kept) continue;
        differences.emplace_back(c.difference);
        centers.push_back(c.center);
        ids.push_back(c.id);
    }
    const ComponentStatistics statistics = component_statistics(differences, centers, distances);
    nlohmann::ordered_json matrix = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < ids.size(); ++k) {
        const auto row = statistics.cosine.begin() + static_cast<std::ptrdiff_t>(k * ids.size());
        matrix.push_back(std::vector<double>(row, row + static_cast<std::ptrdiff_t>(ids.size())));
    }
    return {{"mean", statistics.cosine_mean},
            {"max", statistics.cosine_max},
            {"ids", ids},
            {"matrix", matrix}};
}

}  // namespace

ComponentReport component_report(const std::vector<nn::Component>& components, int level_count,
                                 int vertex_count, DistanceRows& distances) {
    ComponentReport report;
    report.list = nlohmann::ordered_json::array();
    std::vector<int> kept(at(level_count), 0);
    int all_kept = 0;
    for (const nn::Component& c : components) {
        const double share = static_cast<double>(c.support) / vertex_count;
        report.list.push_back({{"id", c.id},
                               {"level", c.level},
                               {"kept", c.kept},
                               {"strength", c.strength},
                               {"support", c.support},
                               {"support_share", share},
                               {"localization_radius", c.localization_radius},
                               {"center_vertex", c.center}});
        if (!c.kept) continue;
        ++kept[at(c.level)];
        ++all_kept;
        report.support_mean += share;
    }
    if (all_kept > 0) report.support_mean /= all_kept;
    report.kept_per_level = kept;
    report.cosine = cosine_json(components, distances);
    return report;
}

}  // namespace mscomp
