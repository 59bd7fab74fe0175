// SPDX-License-Identifier: MIT
#include "mscomp/report/component_export.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "component_json.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/paths.h"
#include "mscomp/render/render.h"
#include "mscomp/report/component_sheets.h"
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

nlohmann::ordered_json describe(const Component& component, const ModelContext& context,
                                bool has_file) {
    nlohmann::ordered_json json = component_json(component, context);
    json["file"] = json["other_file"] = nullptr;
    if (has_file) {
        json["file"] = file_name(component);
        json["other_file"] = other_file_name(component);
    }
    return json;
}

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
    ShownComponents shown;
    int kept = 0;
    for (const int i : strongest_first(components)) {
        const Component& component = components[at(i)];
        throw_if_interrupted(fmt::format("interrupted; nothing was changed in {}", folder));
        const bool has_file = component.kept || options.all;
        list.push_back(describe(component, run.context(), has_file));
        kept += component.kept ? 1 : 0;
        if (has_file) {
            shown.components.push_back(&component);
            shown.shapes.push_back(meshes.colored(component.difference));
            write_colored_ply(output.path(file_name(component)), meshes.whole(shown.shapes.back()));
            write_colored_ply(output.path(other_file_name(component)),
                              meshes.whole(meshes.colored(component.other_difference)));
        }
        if (options.on_progress) {
            options.on_progress(static_cast<std::int64_t>(list.size()),
                                static_cast<std::int64_t>(components.size()));
        }
    }
    nlohmann::ordered_json report{{"run", run_name},
                                  {"kind", run.config.kind},
                                  {"vertices", run.context().mesh().vertex_count()},
                                  {"kept", kept},
                                  {"components", list}};
    write_file(output.path("components.json"), json_text(report, 2) + "\n");
    const std::string title = fmt::format(
        "{} components of {}", kept, std::filesystem::path(run.context().source).stem().string());
    write_png(output.path("overview.png"),
              overview_sheet(title, run, components, shown, options.tile));
    output.commit();
    return report;
}

}  // namespace mscomp
