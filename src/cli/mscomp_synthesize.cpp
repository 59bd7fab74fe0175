// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "component_shape.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/nearest_name.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/nn/synthesis.h"
#include "mscomp_commands.h"
#include "trained_run.h"

namespace mscomp {
namespace {

const nn::Component& component_of(const std::vector<nn::Component>& components,
                                  const std::string& id, const char* option) {
    const auto found = std::ranges::find(components, id, &nn::Component::id);
    if (found != components.end()) return *found;
    std::vector<std::string> ids;
    for (const nn::Component& c : components) ids.push_back(c.id);
    throw UsageError(
        fmt::format("{}: there is no component '{}'; the nearest one is '{}', and --list lists all",
                    option, id, nearest_name(id, ids)));
}

/// "3.1=0.7"
nn::ComponentWeight parse_weight(const std::vector<nn::Component>& components,
                                 const std::string& text) {
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

std::vector<nn::ComponentWeight> parse_weights(const std::vector<nn::Component>& components,
                                               const std::vector<std::string>& texts) {
    std::vector<nn::ComponentWeight> weights;
    for (const std::string& text : texts) {
        const nn::ComponentWeight next = parse_weight(components, text);
        if (std::ranges::find(weights, next.code, &nn::ComponentWeight::code) != weights.end()) {
            throw UsageError(fmt::format("--weight: component '{}' has a weight already",
                                         text.substr(0, text.find('='))));
        }
        weights.push_back(next);
    }
    return weights;
}

/// Rows of the sheet: those asked for, in this order, or the strongest kept ones.
std::vector<const nn::Component*> chosen_components(const std::vector<nn::Component>& components,
                                                    const SynthesizeOptions& options) {
    std::vector<const nn::Component*> chosen;
    for (const std::string& id : options.components) {
        chosen.push_back(&component_of(components, id, "--component"));
    }
    if (!chosen.empty()) return chosen;
    for (const nn::Component& c : components) {
        if (c.kept && (options.level < 0 || c.level == options.level)) chosen.push_back(&c);
    }
    if (chosen.empty()) {
        throw UsageError(
            options.level < 0
                ? std::string("--strongest: the run has no kept component")
                : fmt::format("--level: level {} has no kept component", options.level));
    }
    std::ranges::stable_sort(chosen, [](const nn::Component* a, const nn::Component* b) {
        return a->distance > b->distance;
    });
    chosen.resize(std::min(chosen.size(), at(options.strongest)));
    return chosen;
}

/// Components x weights; each row is coloured by how far its vertices move, full where they move
/// farthest.
class Sheet {
  public:
    Sheet(const nn::ModelContext& context, const ComponentShapes& shapes,
          const nn::Synthesis& synthesis)
        : context_(context), shapes_(shapes), synthesis_(synthesis) {}

    void add_row(const nn::Component& component, const std::vector<double>& weights) {
        std::vector<ColoredShape> row;
        float farthest = 0;
        for (const double weight : weights) {
            const std::vector<nn::ComponentWeight> one{{component.code, weight}};
            ColoredShape shape{shapes_.mesh(synthesis_.change(synthesis_.codes(one))), {}, 0};
            shape.amount = shapes_.displacement(shape.mesh);
            farthest = std::max(farthest, *std::ranges::max_element(shape.amount));
            row.push_back(std::move(shape));
            labels_.push_back(fmt::format("weight {:g}", weight));
        }
        for (ColoredShape& shape : row) shape.full_blue = farthest;
        all_.insert(all_.end(), row.begin(), row.end());
        headings_.push_back(fmt::format(
            "{} (level {}), support {:.0f} %, moves {:.3g}", component.id, component.level,
            100.0 * component.support / context_.reference.vertex_count(), farthest));
    }

    Image draw(const std::string& title, int longer_side) const {
        const SheetView view = common_view(context_.reference, all_, longer_side);
        const std::size_t columns = all_.size() / headings_.size();
        std::vector<SheetTile> tiles;
        for (std::size_t i = 0; i < all_.size(); ++i) {
            tiles.push_back({picture_of(all_[i], view), labels_[i], static_cast<int>(i / columns)});
        }
        return contact_sheet(tiles, headings_, title, static_cast<int>(columns));
    }

  private:
    const nn::ModelContext& context_;
    const ComponentShapes& shapes_;
    const nn::Synthesis& synthesis_;
    std::vector<ColoredShape> all_;
    std::vector<std::string> labels_, headings_;
};

void print_list(const std::vector<nn::Component>& components, int vertices, bool json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    if (!json) fmt::print("id      level  distance  support   reference      end    other\n");
    for (const int i : nn::strongest_first(components)) {
        const nn::Component& c = components[at(i)];
        const double support = static_cast<double>(c.support) / vertices;
        if (!json) {
            fmt::print("{:7} {:5}  {:8.4g}  {:5.1f} %  {:9.3f} {:8.3f} {:8.3f}{}\n", c.id, c.level,
                       c.distance, 100 * support, c.code_reference, c.code_end, c.code_other,
                       c.kept ? "" : "  dropped");
        }
        list.push_back({{"id", c.id},
                        {"level", c.level},
                        {"distance", c.distance},
                        {"support", support},
                        {"code_reference", c.code_reference},
                        {"code_end", c.code_end},
                        {"code_other", c.code_other},
                        {"kept", c.kept}});
    }
    if (json) fmt::print("{}\n", list.dump(2));
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
    if (!options.output.empty()) require_free_file(options.output, options.common.force);
    if (!options.sheet.empty()) require_free_file(options.sheet, options.common.force);
}

void write_synthesized(const std::string& path, const ComponentShapes& shapes,
                       const std::vector<float>& change) {
    if (path.ends_with(".ply")) {
        write_colored_ply(path, shapes.colored(change));
    } else {
        write_mesh(path, shapes.mesh(change));
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
    TrainedRun run = open_run(options.run, 1);
    const nn::ModelContext& context = run.context();
    const std::vector<nn::Component> components = run.components();
    if (options.list) {
        print_list(components, context.reference.vertex_count(), options.common.json);
        return;
    }
    const std::vector<nn::ComponentWeight> weights = parse_weights(components, options.weights);
    std::vector<const nn::Component*> rows;
    if (!options.sheet.empty()) rows = chosen_components(components, options);
    const std::unique_ptr<nn::CodeDecoder> decoder = run.model->decoder();
    const nn::Synthesis synthesis(*decoder, components, context.factor);
    const ComponentShapes shapes(context);

    nlohmann::ordered_json report{{"run", options.run}, {"kind", run.config.kind}};
    nlohmann::ordered_json files = nlohmann::ordered_json::array();
    if (!options.output.empty()) {
        const std::vector<float> codes = synthesis.codes(weights);
        write_synthesized(options.output, shapes, synthesis.change(codes));
        for (const nn::ComponentWeight& w : weights) {
            report["weights"][components[at(w.code)].id] = w.weight;
        }
        for (const nn::Component& c : components) {
            report["codes"][c.id] = codes[at(c.code)];
        }
        files.push_back(options.output);
    }
    if (!options.sheet.empty()) {
        Sheet sheet(context, shapes, synthesis);
        Progress progress("synthesize", static_cast<std::int64_t>(rows.size()),
                          progress_options(options.common.quiet));
        for (std::size_t i = 0; i < rows.size(); ++i) {
            throw_if_interrupted("interrupted; the sheet is not written");
            sheet.add_row(*rows[i], options.sheet_weights);
            report["sheet_components"].push_back(rows[i]->id);
            progress.update(static_cast<std::int64_t>(i + 1));
        }
        report["sheet_weights"] = options.sheet_weights;
        const std::string title =
            "Components of " + std::filesystem::path(context.source).stem().string();
        write_png(options.sheet, sheet.draw(title, options.tile));
        files.push_back(options.sheet);
    }
    report["files"] = files;
    if (options.common.json) {
        fmt::print("{}\n", report.dump(2));
        return;
    }
    for (const auto& file : files) fmt::print("{}\n", file.get<std::string>());
}

}  // namespace mscomp
