// SPDX-License-Identifier: MIT
#include "mscomp/report/component_export.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "component_json.h"
#include "component_sides.h"
#include "mscomp/acap/area_metric.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/paths.h"
#include "mscomp/render/overview.h"
#include "mscomp/render/render.h"
#include "mscomp/run/component_meshes.h"

namespace mscomp {
namespace {

/// "level1_3.2.ply": sorts coarse to fine.
std::string file_name(const Component& component) {
    return fmt::format("level{}_{}.ply", component.level, component.id);
}
std::string other_file_name(const Component& component) {
    return fmt::format("level{}_{}_other.ply", component.level, component.id);
}

/// Of a component of `all`.
nlohmann::ordered_json describe(const Component& component, const std::vector<Component>& all,
                                const ModelContext& context, bool has_file) {
    nlohmann::ordered_json json = component_json(component, context);
    nlohmann::ordered_json others = nlohmann::ordered_json::array();
    for (const FollowingCode& other : component.others) {
        others.push_back({{"id", all[at(other.code)].id}, {"ratio", other.ratio}});
    }
    json["moves_with"] = others;
    json["file"] = json["other_file"] = nullptr;
    if (has_file) {
        json["file"] = file_name(component);
        json["other_file"] = other_file_name(component);
    }
    json["largest_displacement"] = json["near_empty"] = json["seen_from"] = nullptr;
    return json;
}

/// A component in the order of the list, with what is drawn of it.
struct ListedMotion {
    const Component* component = nullptr;
    ShownMotion motion;  // without places of vertices where it is not exported
    int partner = -1;    // its mirror image in the list
};

/// Which of `listed` stand in the overview, coarse to fine: those that are drawn and, so that each
/// is beside its parent, all that they refine; a mirror partner comes next. Gives them their
/// parents, as numbers of this selection.
std::vector<int> shown_with_parents(std::vector<ListedMotion>& listed) {
    std::map<std::string, int> numbers;
    for (std::size_t i = 0; i < listed.size(); ++i) {
        numbers[listed[i].component->id] = static_cast<int>(i);
    }
    const auto parent_of = [&](int i) {
        const auto entry = numbers.find(listed[at(i)].component->parent);
        return entry == numbers.end() ? -1 : entry->second;
    };
    std::vector<bool> is_shown(listed.size());
    for (std::size_t i = 0; i < listed.size(); ++i) {
        if (listed[i].motion.moved.empty()) continue;
        for (int k = static_cast<int>(i); k >= 0; k = parent_of(k)) is_shown[at(k)] = true;
    }
    std::vector<int> shown, place(listed.size(), -1);
    const auto show = [&](int i) {
        if (i < 0 || !is_shown[at(i)] || place[at(i)] >= 0) return;
        const int parent = parent_of(i);
        listed[at(i)].motion.parent = parent < 0 ? -1 : place[at(parent)];
        place[at(i)] = static_cast<int>(shown.size());
        shown.push_back(i);
    };
    for (std::size_t i = 0; i < listed.size(); ++i) {
        show(static_cast<int>(i));
        const int partner = listed[i].partner;
        const bool is_beside =
            partner >= 0 && listed[at(partner)].component->level == listed[i].component->level;
        if (is_beside) show(partner);
    }
    return shown;
}

/// What the overview says about a component.
void describe_motion(const OverviewPlan& plan, std::size_t number, nlohmann::ordered_json& json) {
    const OverviewTile& tile = plan.tiles[number];
    json["largest_displacement"] = plan.diagonal > 0 ? tile.motion.largest / plan.diagonal : 0;
    json["near_empty"] = tile.near_empty;
    json["seen_from"] = {{"azimuth", tile.viewpoint.azimuth},
                         {"elevation", tile.viewpoint.elevation}};
}

/// Where components act, once it is known how the shape stands.
class Sides {
  public:
    /// Of components in the order of `listed`.
    Sides(const TrainedRun& run, const std::vector<Component>& components,
          const std::vector<int>& listed) {
        if (run.model->rows() == ShapeRows::features) roots_ = area_metric(run.reference());
        mirror_ = mirror_of(run.reference());
        if (!mirror_) return;
        std::vector<int> place(components.size());
        for (std::size_t i = 0; i < listed.size(); ++i) place[at(listed[i])] = static_cast<int>(i);
        const auto sides = component_sides(components, run.reference(), *mirror_);
        for (const int i : listed) {
            sides_.push_back(sides[at(i)]);
            if (sides_.back().partner >= 0) {
                sides_.back().partner = place[at(sides_.back().partner)];
            }
        }
    }
    /// In the list; -1: none.
    int partner(std::size_t i) const { return sides_.empty() ? -1 : sides_[i].partner; }
    void describe(std::size_t i, const std::vector<ListedMotion>& listed, const Stance& stance,
                  nlohmann::ordered_json& json) const {
        json["acts"] = json["side"] = json["mirror_partner"] = nullptr;
        if (!roots_.empty()) {
            const std::string acts = way_of_acting(listed[i].component->difference, roots_);
            if (!acts.empty()) json["acts"] = acts;
        }
        if (sides_.empty()) return;
        const std::string side = side_name(sides_[i], *mirror_, stance);
        if (!side.empty()) json["side"] = side;
        if (partner(i) >= 0) json["mirror_partner"] = listed[at(partner(i))].component->id;
    }

  private:
    std::vector<float> roots_;  // of features
    std::optional<Mirror> mirror_;
    std::vector<ComponentSide> sides_;
};

/// Meshes that an earlier export into this folder names: they would stand beside the new ones.
void drop_earlier_export(const std::string& folder, OutputFolder& output) {
    const std::string list = folder + "/components.json";
    if (!path_exists(list)) return;
    const auto earlier = sound_json<nlohmann::json>(read_file(list));
    if (!earlier || !earlier->is_object() || !earlier->contains("components")) return;
    for (const auto& component : earlier->at("components")) {
        for (const char* key : {"file", "other_file"}) {
            if (!component.is_object() || !component.contains(key)) continue;
            const std::string name =
                component[key].is_string() ? component[key].get<std::string>() : std::string();
            // Only names that we give: level0_3.ply.
            if (name.starts_with("level") && name.ends_with(".ply") &&
                name.find('/') == std::string::npos) {
                output.drop(name);
            }
        }
    }
}

}  // namespace

nlohmann::ordered_json export_components(TrainedRun& run, const std::string& run_name,
                                         const std::string& folder,
                                         const ComponentExportOptions& options) {
    const std::vector<Component> components = run.components();
    const ComponentMeshes meshes(run.context(), run.model->rows());
    OutputFolder output(folder);
    drop_earlier_export(folder, output);

    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    std::vector<ListedMotion> listed;
    int kept = 0;
    const std::vector<int> order = strongest_first(components);
    const Sides sides(run, components, order);
    for (const int i : order) {
        const Component& component = components[at(i)];
        throw_if_interrupted(fmt::format("interrupted; nothing was changed in {}", folder));
        const bool has_file = component.kept || options.all;
        list.push_back(describe(component, components, run.context(), has_file));
        kept += component.kept ? 1 : 0;
        listed.push_back({&component, {component.id, -1, {}}, sides.partner(listed.size())});
        if (has_file) {
            ColoredShape shape = meshes.colored(component.difference);
            write_colored_ply(output.path(file_name(component)), meshes.whole(shape));
            listed.back().motion.moved = std::move(shape.mesh.vertices);
            write_colored_ply(output.path(other_file_name(component)),
                              meshes.whole(meshes.colored(component.other_difference)));
        }
        if (options.on_progress) {
            options.on_progress(static_cast<std::int64_t>(list.size()),
                                static_cast<std::int64_t>(components.size()));
        }
    }
    OverviewOptions overview;
    overview.title = fmt::format("{} components of {}", kept,
                                 std::filesystem::path(run.context().source).stem().string());
    overview.tile = options.tile;
    overview.up = options.up;
    overview.view = options.view;
    const std::vector<int> shown = shown_with_parents(listed);
    std::vector<ShownMotion> motions;
    for (const int i : shown) motions.push_back(std::move(listed[at(i)].motion));
    const OverviewPlan plan = plan_overview(run.reference(), motions, overview);
    for (std::size_t k = 0; k < motions.size(); ++k) {
        if (!motions[k].moved.empty()) describe_motion(plan, k, list[at(shown[k])]);
    }
    for (std::size_t i = 0; i < listed.size(); ++i) {
        sides.describe(i, listed, plan.stance, list[i]);
    }
    write_png(output.path("overview.png"), draw_overview(run.reference(), motions, plan, overview));
    const nlohmann::ordered_json stance{{"up", axis_name(plan.stance.up)},
                                        {"up_guessed", plan.is_up_guessed},
                                        {"front", axis_name(plan.stance.front)}};
    nlohmann::ordered_json report{{"run", run_name},
                                  {"kind", run.config.kind},
                                  {"vertices", run.context().mesh().vertex_count()},
                                  {"kept", kept},
                                  {"stance", stance},
                                  {"components", list}};
    write_file(output.path("components.json"), json_text(report, 2) + "\n");
    output.commit();
    return report;
}

}  // namespace mscomp
