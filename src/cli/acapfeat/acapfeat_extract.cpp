// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <utility>

#include "acapfeat_commands.h"
#include "cli/number_of.h"
#include "cli/progress.h"
#include "cli/say.h"
#include "mesh_inputs.h"
#include "mscomp/acap/extract.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/natural_order.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/outputs.h"
#include "mscomp/base/parsed_number.h"

namespace mscomp {
namespace {

/// All shapes of mesh files but the last, which is there as the reference.
class AllButTheLast final : public ShapeSource {
  public:
    explicit AllButTheLast(const MeshFiles& files)
        : files_(files), names_(shape_names({files.paths().begin(), files.paths().end() - 1})) {}

    const std::vector<std::string>& names() const override { return names_; }
    const std::vector<Face>& faces() const override { return files_.faces(); }
    int vertex_count() const override { return files_.vertex_count(); }
    std::vector<int> face_numbers() const override { return files_.face_numbers(); }
    std::vector<std::string> warnings() const override { return files_.warnings(); }
    std::vector<Point> shape(int index) const override { return files_.shape(index); }

  private:
    const MeshFiles& files_;
    std::vector<std::string> names_;
};

/// What stands before the warnings of the features.
std::vector<std::string> warnings_of_inputs(const ShapeSource& shapes, const VertexPlaces& places,
                                            const FeatureSet& set) {
    std::vector<std::string> warnings = shapes.warnings();
    const SurfaceConnectivity connectivity = analyze_connectivity(
        set.vertex_count(), set.reference.faces, shapes.face_numbers(), places);
    warnings.insert(warnings.end(), connectivity.report.warnings.begin(),
                    connectivity.report.warnings.end());
    return warnings;
}

/// `doubt` is about the order of the shapes.
FeatureSet extract_to_file(const ShapeSource& shapes, const std::vector<Point>& reference,
                           const std::string& doubt, const ExtractCommand& options) {
    ExtractOptions extraction{parse_edge_weights(options.weights), options.align, {}};
    extraction.places = vertex_places(shapes, reference);
    FeatureFileWriter file(options.output, feature_outline(shapes, reference, extraction),
                           *extraction.places);
    const auto stop_if_interrupted = [] {
        throw_if_interrupted("interrupted; nothing was written");
    };
    Progress progress("extract", shapes.shape_count(), progress_options(options.common.quiet));
    FeatureSet set = extract_features(shapes, reference, extraction, file, [&](int done, int) {
        stop_if_interrupted();
        progress.update(done);
    });
    const std::vector<std::string> before = warnings_of_inputs(shapes, *extraction.places, set);
    set.warnings.insert(set.warnings.begin(), before.begin(), before.end());
    if (!doubt.empty()) set.warnings.insert(set.warnings.begin(), doubt);
    stop_if_interrupted();
    file.finish(set);
    return set;
}

void require_own_output(const ExtractCommand& options, const std::vector<std::string>& paths) {
    std::vector<std::string> inputs = paths;
    inputs.push_back(options.list);
    inputs.push_back(options.reference);
    require_apart({options.output}, inputs);
}

FeatureSet extract(const ExtractCommand& options) {
    std::vector<std::string> paths = mesh_paths(options.inputs, options.list);
    require_own_output(options, paths);
    const std::string doubt = options.list.empty() ? NaturalOrder(paths).doubt() : "";
    if (const std::optional<std::int64_t> index = parsed_number<std::int64_t>(options.reference)) {
        const auto count = static_cast<std::int64_t>(paths.size());
        if (*index < 0 || *index >= count) {
            throw UsageError(fmt::format("--reference: got {}, wanted 0 to {}, or a mesh file",
                                         *index, count - 1));
        }
        const MeshFiles files(std::move(paths), static_cast<int>(*index));
        return extract_to_file(files, files.shape(static_cast<int>(*index)), doubt, options);
    }
    // Read along with the shapes, the reference has to have the same connectivity; named as the
    // last, it takes no name away from a shape.
    paths.push_back(options.reference);
    const auto last = static_cast<int>(paths.size()) - 1;
    const MeshFiles files(std::move(paths), last);
    const AllButTheLast shapes(files);
    return extract_to_file(shapes, files.shape(last), doubt, options);
}

void print_summary(const FeatureSet& set, const ExtractCommand& options) {
    const double energy =
        std::accumulate(set.consistency_energy.begin(), set.consistency_energy.end(), 0.0);
    const double jump = set.largest_jump.empty()
                            ? 0.0
                            : *std::max_element(set.largest_jump.begin(), set.largest_jump.end());
    int proved = 0;
    for (int n = 0; n < set.shape_count(); ++n) proved += set.is_proved(n) ? 1 : 0;
    if (options.common.json) {
        const nlohmann::ordered_json summary{
            {"file", options.output},         {"shapes", set.shape_count()},
            {"vertices", set.vertex_count()}, {"faces", set.reference.face_count()},
            {"weights", set.weights},         {"aligned", options.align},
            {"consistency_energy", energy},   {"proved", proved},
            {"largest_jump", jump},           {"warnings", set.warnings}};
        print_lines(json_text(summary, 2) + "\n");
        return;
    }
    print_out("{}: {}, {}, {}\n", options.output, number_of_shapes(set.shape_count()),
              number_of_vertices(set.vertex_count()),
              number_of(set.reference.face_count(), "face", "faces"));
    print_out(
        "consistency energy {:.6g} in all, proved least for {} of {}; largest jump across "
        "an edge {:.4g} rad\n",
        energy, proved, number_of_shapes(set.shape_count()), jump);
    if (options.common.quiet) return;
    for (const std::string& warning : set.warnings) {
        say("acapfeat: warning: {}\n", warning);
    }
}

}  // namespace

void setup_extract(CLI::App& app) {
    const auto options = std::make_shared<ExtractCommand>();
    CLI::App* command =
        app.add_subcommand("extract", "ACAP features of meshes of one connectivity");
    command->add_option("INPUT", options->inputs,
                        "Mesh files, folders or quoted globs; used in natural order");
    command->add_option("--list", options->list,
                        "File naming the meshes in order, one per line, relative to its folder");
    command->add_option("-o,--output", options->output, "Feature file to write")->required();
    command
        ->add_option("--reference", options->reference,
                     "Reference shape: index from 0, or a mesh file")
        ->capture_default_str();
    command->add_option("--weights", options->weights, "Edge weights")
        ->check(CLI::IsMember({"cotangent", "authors", "uniform"}))
        ->capture_default_str();
    command->add_flag_callback(
        "--no-align", [options] { options->align = false; },
        "Keep the input where it is instead of moving each shape to the reference");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "acapfeat extract swing/*.obj -o swing.safetensors --reference 0");
    command->callback([options] { run_extract(*options); });
}

void run_extract(const ExtractCommand& options) {
    require_extension(options.output, "a feature file", {"safetensors"});
    require_free_file(options.output, options.common.force);
    print_summary(extract(options), options);
}

}  // namespace mscomp
