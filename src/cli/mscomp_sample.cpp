// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "component_shape.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/nn/synthesis.h"
#include "mscomp_commands.h"
#include "number_of.h"
#include "seed_option.h"
#include "trained_run.h"

namespace mscomp {
namespace {

bool has_prior(const TrainedRun& run) { return run.config.kind == "spectral-vae"; }

nn::CodeDistribution distribution_of(const SampleOptions& options, const TrainedRun& run) {
    const std::string from =
        !options.from.empty() ? options.from : (has_prior(run) ? "prior" : "fitted");
    if (from == "fitted") {
        return options.independent ? nn::CodeDistribution::independent
                                   : nn::CodeDistribution::fitted;
    }
    if (!has_prior(run)) {
        throw UsageError(
            fmt::format("--from prior: a model of kind {} has no prior, its codes may have any "
                        "size; wanted --from fitted",
                        run.config.kind));
    }
    if (options.independent) {
        throw UsageError(
            "--independent: the codes of the prior are independent already; wanted "
            "--from fitted");
    }
    return nn::CodeDistribution::prior;
}

std::string name_of(nn::CodeDistribution distribution) {
    return distribution == nn::CodeDistribution::prior ? "prior" : "fitted";
}

/// Root mean square over all codes of their deviation over the training shapes; the prior has 1.
double code_deviation(const TrainedRun& run) {
    double squares = 0, count = 0;
    const std::size_t shapes = run.context().train_shapes.size();
    for (const std::vector<float>& level : run.file.codes()) {
        const std::size_t width = level.size() / shapes;
        for (std::size_t k = 0; k < width; ++k) {
            double mean = 0, square = 0;
            for (std::size_t i = k; i < level.size(); i += width) {
                mean += static_cast<double>(level[i]) / static_cast<double>(shapes);
            }
            for (std::size_t i = k; i < level.size(); i += width) {
                square += (level[i] - mean) * (level[i] - mean);
            }
            squares += square / static_cast<double>(shapes);
            count += 1;
        }
    }
    return std::sqrt(squares / count);
}

/// One line per sample: its name and all codes, with digits enough for float32.
std::string code_table(const std::vector<nn::Component>& components,
                       const std::vector<std::string>& names,
                       const std::vector<std::vector<float>>& codes) {
    std::string text = "sample";
    for (const nn::Component& c : components) text += "," + c.id;
    text += "\n";
    for (std::size_t i = 0; i < names.size(); ++i) {
        text += names[i];
        for (const float code : codes[i]) text += fmt::format(",{:.9g}", code);
        text += "\n";
    }
    return text;
}

/// The reference and the samples, uncoloured.
Image overview(const TrainedRun& run, const std::vector<ColoredShape>& shapes,
               const std::vector<std::string>& names, int longer_side, const std::string& title) {
    const TriangleMesh& reference = run.context().reference;
    const SheetView view = common_view(reference, shapes, longer_side);
    std::vector<SheetTile> tiles{{picture_of({reference, {}, 0}, view), "reference", 0}};
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        tiles.push_back({picture_of(shapes[i], view), names[i], 0});
    }
    constexpr int kSheetWidth = 2000;
    const int columns = std::clamp(kSheetWidth / view.width, 1, static_cast<int>(tiles.size()));
    return contact_sheet(tiles, {"Random shapes"}, title, columns);
}

}  // namespace

void setup_sample(CLI::App& app) {
    const auto options = std::make_shared<SampleOptions>();
    CLI::App* command = app.add_subcommand("sample", "Make random shapes");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    command->add_option("-n,--count", options->count, "Number of shapes")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command->add_option("-o,--output", options->output, "Folder to write to")->required();
    command->add_option("--seed", options->seed, "Which shapes")
        ->check(is_seed)
        ->capture_default_str();
    command
        ->add_option("--from", options->from,
                     "prior: N(0, I), for spectral-vae; fitted: the Gaussian of the training codes "
                     "[prior for spectral-vae, fitted for others]")
        ->check(CLI::IsMember({"prior", "fitted"}));
    command->add_flag("--independent", options->independent,
                      "With fitted: every component by itself");
    command->add_option("--format", options->format, "Format of the meshes")
        ->check(CLI::IsMember({"obj", "ply", "off"}))
        ->capture_default_str();
    command->add_option("--tile", options->tile, "Pixels per side of one shape in overview.png")
        ->check(CLI::Range(64, 1024))
        ->capture_default_str();
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp sample swing.run -n 12 -o samples --seed 1");
    command->callback([options] { run_sample(*options); });
}

void run_sample(const SampleOptions& options) {
    require_free_folder(options.output, options.common.force);
    TrainedRun run = open_run(options.run, 1);
    const nn::ModelContext& context = run.context();
    const nn::CodeDistribution distribution = distribution_of(options, run);
    const nn::CodeSampler sampler(distribution, run.file.codes(),
                                  static_cast<int>(context.train_shapes.size()), options.seed);
    const std::vector<nn::Component> components = run.components();
    const std::unique_ptr<nn::CodeDecoder> decoder = run.model->decoder();
    const LosslessReconstruction reconstruction(context.reference,
                                                parse_edge_weights(context.weights));
    create_folder(options.output);

    constexpr int kMostDrawn = 60;
    const int digits = static_cast<int>(std::to_string(options.count).size());
    std::vector<std::string> names, files;
    std::vector<std::vector<float>> codes;
    std::vector<ColoredShape> drawn;
    Progress progress("sample", options.count, progress_options(options.common.quiet));
    for (int i = 0; i < options.count; ++i) {
        throw_if_interrupted(fmt::format("interrupted; {} of {} meshes are in {}", i, options.count,
                                         options.output));
        codes.push_back(sampler.draw(static_cast<std::uint64_t>(i)));
        std::vector<float> features = decoder->decode(codes.back());
        run.scaler().unscale(features);
        TriangleMesh mesh{reconstruction.solve(features).vertices, context.reference.faces};
        names.push_back(fmt::format("sample_{:0{}}", i, digits));
        files.push_back(fmt::format("{}/{}.{}", options.output, names.back(), options.format));
        write_mesh(files.back(), mesh);
        if (i < kMostDrawn) drawn.push_back({std::move(mesh), {}, 0});
        progress.update(i + 1);
    }
    write_file(options.output + "/codes.csv", code_table(components, names, codes));
    const std::string title =
        fmt::format("{} of {}, {}{}, seed {}", number_of_shapes(options.count),
                    std::filesystem::path(context.source).stem().string(), name_of(distribution),
                    options.independent ? ", independent" : "", options.seed);
    write_png(options.output + "/overview.png", overview(run, drawn, names, options.tile, title));
    if (options.common.json) {
        const nlohmann::ordered_json report{{"run", options.run},
                                            {"kind", run.config.kind},
                                            {"from", name_of(distribution)},
                                            {"independent", options.independent},
                                            {"seed", options.seed},
                                            {"code_deviation", code_deviation(run)},
                                            {"codes", options.output + "/codes.csv"},
                                            {"overview", options.output + "/overview.png"},
                                            {"files", files}};
        fmt::print("{}\n", report.dump(2));
        return;
    }
    const bool prior = distribution == nn::CodeDistribution::prior;
    fmt::print("{}: {} from the {}, codes.csv and overview.png\n", options.output,
               number_of_shapes(options.count), prior ? "prior" : "Gaussian of the training codes");
    if (prior) {
        fmt::print("codes of the prior deviate by 1, those of the training shapes by {:.3g}\n",
                   code_deviation(run));
    }
}

}  // namespace mscomp
