// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/progress.h"
#include "cli/say.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/nearest_name.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "mscomp/model/synthesis.h"
#include "mscomp/report/component_sheets.h"
#include "mscomp/run/component_meshes.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/trained_run.h"
#include "mscomp_commands.h"
#include "report/component_json.h"

namespace mscomp {
namespace {

const Component& component_of(const std::vector<Component>& components, const std::string& id,
                              const char* option) {
    const auto found = std::ranges::find(components, id, &Component::id);
    if (found != components.end()) return *found;
    std::vector<std::string> ids;
    for (const Component& c : components) ids.push_back(c.id);
    throw UsageError(
        fmt::format("{}: there is no component '{}'; the nearest one is '{}', and --list lists all",
                    option, id, nearest_name(id, ids)));
}

/// "3.1=0.7"
ComponentWeight parse_weight(const std::vector<Component>& components, const std::string& text) {
    const std::size_t sign = text.find('=');
    double weight = 0;
    const char* end = text.data() + text.size();
    const auto parsed = sign == std::string::npos
                            ? std::from_chars_result{nullptr, std::errc::invalid_argument}
                            : std::from_chars(text.data() + sign + 1, end, weight);
    if (parsed.ec != std::errc{} || parsed.ptr != end || !std::isfinite(weight)) {
        throw UsageError(fmt::format(
            "--weight: got '{}', wanted ID=W with a number W, for example 3.1=0.7", text));
    }
    return {component_of(components, text.substr(0, sign), "--weight").code, weight};
}

std::vector<ComponentWeight> parse_weights(const std::vector<Component>& components,
                                           const std::vector<std::string>& texts) {
    std::vector<ComponentWeight> weights;
    for (const std::string& text : texts) {
        const ComponentWeight next = parse_weight(components, text);
        if (std::ranges::find(weights, next.code, &ComponentWeight::code) != weights.end()) {
            throw UsageError(fmt::format("--weight: component '{}' has a weight already",
                                         text.substr(0, text.find('='))));
        }
        weights.push_back(next);
    }
    return weights;
}

/// Rows of the sheet: those asked for, in this order, or the strongest kept ones.
std::vector<const Component*> chosen_components(const std::vector<Component>& components,
                                                const SynthesizeOptions& options) {
    std::vector<const Component*> chosen;
    for (const std::string& id : options.components) {
        chosen.push_back(&component_of(components, id, "--component"));
    }
    if (!chosen.empty()) return chosen;
    for (const int i : farthest_first(components)) {
        const Component& c = components[at(i)];
        if (c.kept && (options.level < 0 || c.level == options.level)) chosen.push_back(&c);
    }
    if (chosen.empty()) {
        throw UsageError(
            options.level < 0
                ? std::string("--strongest: the run has no kept component")
                : fmt::format("--level: level {} has no kept component", options.level));
    }
    chosen.resize(std::min(chosen.size(), at(options.strongest)));
    return chosen;
}

std::string state_of(const Component& component) {
    if (component.kept) return {};
    return component.merged_into.empty() ? "  dropped" : "  merged into " + component.merged_into;
}

void print_list(const std::vector<Component>& components, const ModelContext& context, bool json) {
    const int vertices = context.reference.vertex_count();
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    if (!json) print_out("id      level  distance  support   reference      end    other\n");
    for (const int i : strongest_first(components)) {
        const Component& c = components[at(i)];
        list.push_back(component_json(c, context));
        if (json) continue;
        print_out("{:7} {:5}  {:8.4g}  {:5.1f} %  {:9.3f} {:8.3f} {:8.3f}{}\n", c.id, c.level,
                  c.distance, 100.0 * c.support / vertices, c.code_reference, c.code_end,
                  c.code_other, state_of(c));
    }
    if (json) print_lines(json_text(list, 2) + "\n");
}

/// Throws where options do not go together or output stands in the way.
void check_options(const SynthesizeOptions& options) {
    if (options.list) return;
    if (options.output.empty() && options.sheet.empty()) {
        throw UsageError("wanted -o FILE for a mesh, --sheet FILE for a picture, or --list");
    }
    if (options.output.empty() != options.weights.empty()) {
        throw UsageError("--weight and -o FILE go together: got one without the other");
    }
    if (!options.output.empty()) {
        require_extension(options.output, "a mesh", {"obj", "ply", "off"});
        require_free_file(options.output, options.common.force);
    }
    if (!options.sheet.empty()) {
        require_extension(options.sheet, "a picture", {"png"});
        require_free_file(options.sheet, options.common.force);
    }
    require_apart({options.output, options.sheet}, {model_path(options.run)});
}

std::vector<std::string> output_paths(const SynthesizeOptions& options) {
    std::vector<std::string> paths{options.output, options.sheet};
    std::erase(paths, "");
    return paths;
}

void write_synthesized(const std::string& path, const ComponentMeshes& meshes,
                       const std::vector<float>& change) {
    if (path.ends_with(".ply")) {
        write_colored_ply(path, meshes.whole(meshes.colored(change)));
    } else {
        write_mesh(path, meshes.whole(meshes.mesh(change)));
    }
}

}  // namespace

void setup_synthesize(CLI::App& app) {
    const auto options = std::make_shared<SynthesizeOptions>();
    CLI::App* command =
        app.add_subcommand("synthesize", "Make shapes of components, each with a weight");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    command->add_option("--weight", options->weights,
                        "ID=W, several times: component ID goes W of the way from the reference "
                        "to its end; below 0 the other way");
    command->add_option("-o,--output", options->output, "Mesh to write: .obj, .ply or .off");
    command->add_option("--sheet", options->sheet,
                        "Picture (PNG) to write: components by weights, one row each");
    CLI::Option* components = command->add_option("--component", options->components,
                                                  "Components of the sheet by id, several times");
    command->add_option("--strongest", options->strongest, "Or so many of the strongest ones")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str()
        ->excludes(components);
    command->add_option("--level", options->level, "Strongest ones of this level only")
        ->check(CLI::NonNegativeNumber)
        ->excludes(components);
    command->add_option("--weights", options->sheet_weights, "Weights of the sheet")
        ->delimiter(',')
        ->capture_default_str();
    command->add_option("--tile", options->tile, "Pixels per side of one picture of the sheet")
        ->check(CLI::Range(64, 1024))
        ->capture_default_str();
    command->add_flag("--list", options->list, "Only list the components, strongest first");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp synthesize swing.run --weight 3=1 --weight 5=-0.5 -o new.obj");
    command->callback([options] { run_synthesize(*options); });
}

void run_synthesize(const SynthesizeOptions& options) {
    check_options(options);
    TrainedRun run = open_run(options.run);
    const ModelContext& context = run.context();
    const std::vector<Component> components = run.components();
    if (options.list) {
        print_list(components, context, options.common.json);
        return;
    }
    const std::vector<ComponentWeight> weights = parse_weights(components, options.weights);
    std::vector<const Component*> rows;
    if (!options.sheet.empty()) rows = chosen_components(components, options);
    const Synthesis synthesis(*run.model, components);
    const ComponentMeshes meshes(context, run.model->rows());

    OutputFiles outputs(output_paths(options));
    nlohmann::ordered_json report{{"run", options.run}, {"kind", run.config.kind}};
    nlohmann::ordered_json files = nlohmann::ordered_json::array();
    if (!options.output.empty()) {
        const std::vector<float> codes = synthesis.codes(weights);
        write_synthesized(outputs.path(options.output), meshes, synthesis.change(codes));
        auto weight_of = nlohmann::ordered_json::object(), code_of = weight_of;
        for (const ComponentWeight& w : weights) weight_of[components[at(w.code)].id] = w.weight;
        for (const Component& c : components) code_of[c.id] = codes[at(c.code)];
        if (!weights.empty()) report["weights"] = weight_of;
        report["codes"] = code_of;
        files.push_back(options.output);
    }
    if (!options.sheet.empty()) {
        SynthesisSheet sheet(context.reference, meshes, synthesis);
        Progress progress("synthesize", static_cast<std::int64_t>(rows.size()),
                          progress_options(options.common.quiet));
        auto shown = nlohmann::ordered_json::array();
        for (std::size_t i = 0; i < rows.size(); ++i) {
            throw_if_interrupted("interrupted; nothing was written");
            sheet.add_row(*rows[i], options.sheet_weights);
            shown.push_back(rows[i]->id);
            progress.update(static_cast<std::int64_t>(i + 1));
        }
        report["sheet_components"] = shown;
        report["sheet_weights"] = options.sheet_weights;
        const std::string title =
            "Components of " + std::filesystem::path(context.source).stem().string();
        write_png(outputs.path(options.sheet), sheet.draw(title, options.tile));
        files.push_back(options.sheet);
    }
    outputs.commit();
    report["files"] = files;
    if (options.common.json) {
        print_lines(json_text(report, 2) + "\n");
        return;
    }
    for (const auto& file : files) print_out("{}\n", file.get<std::string>());
}

}  // namespace mscomp
