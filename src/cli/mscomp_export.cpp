// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/nn/components.h"
#include "mscomp/render/render.h"
#include "mscomp_commands.h"
#include "trained_run.h"

namespace mscomp {
namespace {

/// A component as a mesh with where it acts, (V): |difference| in unscaled features.
struct DeformedShape {
    TriangleMesh mesh;
    std::vector<float> amount;
    float full_blue = 0;  // the amount that is drawn in full colour
};

/// A few folded vertices can be far above all others: colour is full from the 98th percentile of
/// the vertices that move.
float full_color_amount(const std::vector<float>& amount) {
    std::vector<float> moving;
    std::ranges::copy_if(amount, std::back_inserter(moving), [](float a) { return a > 0; });
    if (moving.empty()) return 0;
    const auto at = moving.begin() + static_cast<std::ptrdiff_t>((moving.size() - 1) * 98 / 100);
    std::nth_element(moving.begin(), at, moving.end());
    return *at;
}

DeformedShape deformed_shape(const nn::Component& component, const TriangleMesh& reference,
                             const LosslessReconstruction& reconstruction) {
    DeformedShape shape;
    std::vector<float> features = component.difference;
    for (std::size_t i = 0; i < features.size(); ++i) {
        if (i % kFeatureDim == 0) {
            float square = 0;
            for (std::size_t c = 0; c < kFeatureDim; ++c)
                square += features[i + c] * features[i + c];
            shape.amount.push_back(std::sqrt(square));
        }
        features[i] += kReferenceFeature[i % kFeatureDim];
    }
    shape.full_blue = full_color_amount(shape.amount);
    shape.mesh = {reconstruction.solve(features).vertices, reference.faces};
    return shape;
}

std::vector<std::array<float, 3>> colors_of(const DeformedShape& shape) {
    std::vector<std::array<float, 3>> colors;
    for (const float amount : shape.amount) {
        colors.push_back(white_to_blue(shape.full_blue > 0 ? amount / shape.full_blue : 0));
    }
    return colors;
}

void write_component_ply(const std::string& path, const DeformedShape& shape) {
    std::vector<VertexColor> colors;
    const auto byte = [](float x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
    for (const auto& color : colors_of(shape)) {
        colors.push_back({byte(color[0]), byte(color[1]), byte(color[2])});
    }
    write_ply(path, shape.mesh, colors, shape.amount);
}

/// "level1_3.2.ply": sorts coarse to fine.
std::string file_name(const nn::Component& component) {
    return fmt::format("level{}_{}.ply", component.level, component.id);
}

nlohmann::ordered_json describe(const nn::Component& c, int vertices, bool has_file) {
    nlohmann::ordered_json json{{"id", c.id},
                                {"level", c.level},
                                {"parent", c.parent},
                                {"center_vertex", c.center},
                                {"longest_vertex", c.longest},
                                {"strength", c.strength},
                                {"kept", c.kept},
                                {"reason", c.reason},
                                {"code_min", c.code_min},
                                {"code_max", c.code_max},
                                {"code_reference", c.code_reference},
                                {"code_end", c.code_end},
                                {"support_vertices", c.support},
                                {"support", static_cast<double>(c.support) / vertices},
                                {"moving", static_cast<double>(c.moving) / vertices},
                                {"localization_radius", c.localization_radius}};
    if (c.parent.empty()) json["parent"] = nullptr;
    if (c.reason.empty()) json["reason"] = nullptr;
    json["file"] =
        has_file ? nlohmann::ordered_json(file_name(c)) : nlohmann::ordered_json(nullptr);
    return json;
}

/// Meshes that an earlier export into this folder names: they would stand beside the new ones.
void remove_earlier_export(const std::string& folder) {
    const std::string list = folder + "/components.json";
    if (!std::filesystem::exists(list)) return;
    const nlohmann::json earlier = nlohmann::json::parse(read_file(list), nullptr, false);
    if (!earlier.is_object() || !earlier.contains("components")) return;
    for (const auto& component : earlier["components"]) {
        const std::string name =
            component.is_object() && component.contains("file") && component["file"].is_string()
                ? component["file"].get<std::string>()
                : std::string();
        // Only names that we give: level0_3.ply.
        if (name.starts_with("level") && name.ends_with(".ply") &&
            name.find('/') == std::string::npos) {
            std::filesystem::remove(std::filesystem::path(folder) / name);
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

struct ShownComponent {
    const nn::Component* component;
    DeformedShape shape;
};

/// One view for all pictures: the direction that suits the reference, wide enough for the shape
/// that reaches farthest.
View common_view(const TriangleMesh& reference, const std::vector<ShownComponent>& shown,
                 int longer_side, std::array<int, 2>& size) {
    std::vector<Point> all = reference.vertices;
    for (const ShownComponent& each : shown) {
        all.insert(all.end(), each.shape.mesh.vertices.begin(), each.shape.mesh.vertices.end());
    }
    const View view = framed(fit_view(reference.vertices), all);
    size = picture_size(view, longer_side);
    return framed(view, all, static_cast<double>(size[0]) / size[1]);
}

/// The contact sheet: the reference, then each level's components under a heading.
Image overview(const std::string& title, const TriangleMesh& reference,
               const std::vector<ShownComponent>& shown, const std::vector<std::string>& headings,
               int longer_side) {
    std::array<int, 2> size{};
    const View view = common_view(reference, shown, longer_side, size);
    std::vector<SheetTile> tiles{
        {render_mesh(reference, {}, view, size[0], size[1]), "reference", 0}};
    for (const auto& [component, shape] : shown) {
        tiles.push_back({render_mesh(shape.mesh, colors_of(shape), view, size[0], size[1]),
                         fmt::format("{}  {:.0f} %", component->id,
                                     100.0 * component->support / reference.vertex_count()),
                         component->level + 1});
    }
    std::vector<std::string> all_headings{"Reference"};
    all_headings.insert(all_headings.end(), headings.begin(), headings.end());
    constexpr int kSheetWidth = 2600;
    const int columns = std::clamp(kSheetWidth / size[0], 1, static_cast<int>(tiles.size()));
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
    const LosslessReconstruction reconstruction(context.reference,
                                                parse_edge_weights(context.weights));
    create_folder(options.output);
    remove_earlier_export(options.output);

    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    std::vector<ShownComponent> shown;
    Progress progress("export", static_cast<std::int64_t>(components.size()),
                      progress_options(options.common.quiet));
    int kept = 0;
    for (const nn::Component& component : components) {
        throw_if_interrupted("interrupted; some components are written, components.json is not");
        const bool has_file = component.kept || options.all;
        list.push_back(describe(component, vertices, has_file));
        kept += component.kept ? 1 : 0;
        if (has_file) {
            shown.push_back(
                {&component, deformed_shape(component, context.reference, reconstruction)});
            write_component_ply(fmt::format("{}/{}", options.output, file_name(component)),
                                shown.back().shape);
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
    fmt::print("{}/components.json and {} PLY files\n", options.output, shown.size());
}

}  // namespace mscomp
