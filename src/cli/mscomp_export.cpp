// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "component_shape.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/index.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/nn/components.h"
#include "mscomp/render/render.h"
#include "mscomp_commands.h"
#include "trained_run.h"

namespace mscomp {
namespace {

/// "level1_3.2.ply": sorts coarse to fine.
std::string file_name(const nn::Component& component) {
    return fmt::format("level{}_{}.ply", component.level, component.id);
}
std::string other_file_name(const nn::Component& component) {
    return fmt::format("level{}_{}_other.ply", component.level, component.id);
}

nlohmann::ordered_json describe(const nn::Component& c, int vertices, bool has_file) {
    nlohmann::ordered_json json{{"id", c.id},
                                {"level", c.level},
                                {"parent", c.parent},
                                {"center_vertex", c.center},
                                {"longest_vertex", c.longest},
                                {"strength", c.strength},
                                {"distance", c.distance},
                                {"kept", c.kept},
                                {"reason", c.reason},
                                {"code_min", c.code_min},
                                {"code_max", c.code_max},
                                {"code_reference", c.code_reference},
                                {"code_end", c.code_end},
                                {"code_other", c.code_other},
                                {"support_vertices", c.support},
                                {"support", static_cast<double>(c.support) / vertices},
                                {"moving", static_cast<double>(c.moving) / vertices},
                                {"localization_radius", c.localization_radius}};
    if (c.parent.empty()) json["parent"] = nullptr;
    if (c.reason.empty()) json["reason"] = nullptr;
    json["file"] = json["other_file"] = nullptr;
    if (has_file) {
        json["file"] = file_name(c);
        json["other_file"] = other_file_name(c);
    }
    return json;
}

/// Meshes that an earlier export into this folder names: they would stand beside the new ones.
void remove_earlier_export(const std::string& folder) {
    const std::string list = folder + "/components.json";
    if (!std::filesystem::exists(list)) return;
    const nlohmann::json earlier = nlohmann::json::parse(read_file(list), nullptr, false);
    if (!earlier.is_object() || !earlier.contains("components")) return;
    for (const auto& component : earlier["components"]) {
        for (const char* key : {"file", "other_file"}) {
            if (!component.is_object() || !component.contains(key)) continue;
            const std::string name =
                component[key].is_string() ? component[key].get<std::string>() : std::string();
            // Only names that we give: level0_3.ply.
            if (name.starts_with("level") && name.ends_with(".ply") &&
                name.find('/') == std::string::npos) {
                std::filesystem::remove(std::filesystem::path(folder) / name);
            }
        }
    }
}

std::string scale_name(std::size_t level, std::size_t levels) {
    if (levels == 1) return "one level";
    return level == 0 ? "coarse" : level + 1 == levels ? "fine" : "middle";
}

std::vector<std::string> level_headings(const std::vector<nn::Component>& components,
                                        const TrainedRun& run) {
    const std::size_t levels = run.model->level_sizes().size();
    std::vector<std::string> headings;
    for (std::size_t l = 0; l < levels; ++l) {
        headings.push_back(fmt::format(
            "Level {} ({}), mean support {:.0f} % of the vertices", l, scale_name(l, levels),
            100 * nn::mean_support(components, static_cast<int>(l), run.model->vertex_count())));
    }
    return headings;
}

/// Components with their ends, in the order of the sheet.
struct ShownComponents {
    std::vector<const nn::Component*> components;
    std::vector<ColoredShape> shapes;
};

/// The contact sheet: the reference, then each level's components under a heading.
Image overview(const std::string& title, const TriangleMesh& reference,
               const ShownComponents& shown, const std::vector<std::string>& headings,
               int longer_side) {
    const SheetView view = common_view(reference, shown.shapes, longer_side);
    std::vector<SheetTile> tiles{{picture_of({reference, {}, 0}, view), "reference", 0}};
    for (std::size_t i = 0; i < shown.components.size(); ++i) {
        const nn::Component& component = *shown.components[i];
        tiles.push_back({picture_of(shown.shapes[i], view),
                         fmt::format("{}  {:.0f} %", component.id,
                                     100.0 * component.support / reference.vertex_count()),
                         component.level + 1});
    }
    std::vector<std::string> all_headings{"Reference"};
    all_headings.insert(all_headings.end(), headings.begin(), headings.end());
    constexpr int kSheetWidth = 2600;
    const int columns = std::clamp(kSheetWidth / view.width, 1, static_cast<int>(tiles.size()));
    return contact_sheet(tiles, all_headings, title, columns);
}

}  // namespace

void setup_export(CLI::App& app) {
    const auto options = std::make_shared<ExportOptions>();
    CLI::App* command = app.add_subcommand(
        "export-components", "Write the learnt components as coloured meshes and one picture");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    command->add_option("-o,--output", options->output, "Folder to write to")->required();
    command->add_flag("--all", options->all, "Also components that the redundancy filter drops");
    command->add_option("--tile", options->tile, "Pixels per side of one component in overview.png")
        ->check(CLI::Range(64, 1024))
        ->capture_default_str();
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp export-components swing.run -o components");
    command->callback([options] { run_export(*options); });
}

void run_export(const ExportOptions& options) {
    require_free_folder(options.output, options.common.force);
    TrainedRun run = open_run(options.run, 1);
    const nn::ModelContext& context = run.context();
    const int vertices = context.reference.vertex_count();
    const std::vector<nn::Component> components = run.components();
    const ComponentShapes shapes(context);
    create_folder(options.output);
    remove_earlier_export(options.output);

    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    ShownComponents shown;
    Progress progress("export", static_cast<std::int64_t>(components.size()),
                      progress_options(options.common.quiet));
    int kept = 0;
    for (const int i : nn::strongest_first(components)) {
        const nn::Component& component = components[at(i)];
        throw_if_interrupted("interrupted; some components are written, components.json is not");
        const bool has_file = component.kept || options.all;
        list.push_back(describe(component, vertices, has_file));
        kept += component.kept ? 1 : 0;
        if (has_file) {
            shown.components.push_back(&component);
            shown.shapes.push_back(shapes.colored(component.difference));
            write_colored_ply(options.output + "/" + file_name(component), shown.shapes.back());
            write_colored_ply(options.output + "/" + other_file_name(component),
                              shapes.colored(component.other_difference));
        }
        progress.update(static_cast<std::int64_t>(list.size()));
    }
    nlohmann::ordered_json report{{"run", options.run},
                                  {"kind", run.config.kind},
                                  {"vertices", vertices},
                                  {"kept", kept},
                                  {"components", list}};
    write_file(options.output + "/components.json", report.dump(2) + "\n");
    const std::string title = fmt::format("{} components of {}", kept,
                                          std::filesystem::path(context.source).stem().string());
    write_png(
        options.output + "/overview.png",
        overview(title, context.reference, shown, level_headings(components, run), options.tile));
    if (options.common.json) {
        fmt::print("{}\n", report.dump(2));
        return;
    }
    fmt::print("{}/overview.png: {} of {} components kept\n", options.output, kept,
               components.size());
    fmt::print("{}/components.json and {} PLY files\n", options.output,
               2 * shown.components.size());
}

}  // namespace mscomp
