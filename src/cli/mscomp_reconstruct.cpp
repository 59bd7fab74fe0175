// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/cli/shape_files.h"
#include "mscomp/eval/measures.h"
#include "mscomp_commands.h"
#include "trained_run.h"

namespace mscomp {
namespace {

constexpr int kBatch = 64;

void require_same_mesh(const FeatureSet& set, const TrainedRun& run, const std::string& path) {
    const TriangleMesh& reference = run.context().reference;
    if (set.vertex_count() != reference.vertex_count()) {
        throw InputError({path}, fmt::format("{} vertices, but the model was trained on {}",
                                             set.vertex_count(), reference.vertex_count()));
    }
    if (set.reference.faces != reference.faces) {
        throw InputError({path}, "other faces than the model was trained on");
    }
}

std::vector<int> chosen_shapes(const DecodeOptions& options, const TrainedRun& run, int count) {
    std::vector<int> shapes;
    if (options.split == "all") {
        shapes.resize(static_cast<std::size_t>(count));
        std::iota(shapes.begin(), shapes.end(), 0);
        return shapes;
    }
    shapes = options.split == "train" ? run.context().train_shapes : run.context().test_shapes;
    if (shapes.empty()) throw UsageError(fmt::format("--split {}: has no shapes", options.split));
    if (shapes.back() >= count) {
        throw InputError({options.features}, fmt::format("{} shapes, but --split {} names shape {}",
                                                         count, options.split, shapes.back()));
    }
    return shapes;
}

/// What comes out beside the meshes.
struct Fit {
    double rms_error = 0;
    double relative_squared_error_max = 0;
};

Fit decode_shapes(const DecodeOptions& options, TrainedRun& run, const FeatureFile& file,
                  const std::vector<int>& shapes, int levels) {
    const FeatureScaler scaler = run.scaler();
    FeatureScaler minmax;
    minmax.offset = run.context().minmax_offset;
    minmax.factor = run.context().minmax_factor;
    const LosslessReconstruction reconstruction(run.context().reference,
                                                parse_edge_weights(run.context().weights));
    const std::vector<std::string> names = shape_file_names(file.outline().names);
    const nn::ScaledFeatures scaled{file, scaler.offset, scaler.factor};
    RmsError rms(run.context().reference.vertices);
    Fit fit;
    Progress progress("reconstruct", static_cast<std::int64_t>(shapes.size()),
                      progress_options(options.common.quiet));
    const auto size = static_cast<std::size_t>(file.vertex_count()) * kFeatureDim;
    for (std::size_t first = 0; first < shapes.size(); first += kBatch) {
        const std::span<const int> batch = std::span<const int>(shapes).subspan(
            first, std::min<std::size_t>(kBatch, shapes.size() - first));
        run.model->load_batch(scaled, batch);
        run.model->forward();
        std::vector<float> decoded = run.model->reconstruction(levels);
        scaler.unscale(decoded);
        for (std::size_t m = 0; m < batch.size(); ++m) {
            throw_if_interrupted(fmt::format("interrupted; {} of {} meshes are in {}", first + m,
                                             shapes.size(), options.output));
            const auto shape = static_cast<std::size_t>(batch[m]);
            std::vector<float> result(
                decoded.begin() + static_cast<std::ptrdiff_t>(m * size),
                decoded.begin() + static_cast<std::ptrdiff_t>((m + 1) * size));
            const std::vector<Point> input = points_of(file.vertices(batch[m]));
            const TriangleMesh mesh{reconstruction.solve(result, input).vertices,
                                    run.context().reference.faces};
            write_obj(fmt::format("{}/{}.obj", options.output, names[shape]), mesh);
            rms.add(input, mesh.vertices);
            const std::span<const float> features = file.shape(batch[m]);
            std::vector<float> truth(features.begin(), features.end());
            file.forget(batch[m]);
            const bool is_reference =
                std::ranges::all_of(truth, [i = std::size_t{0}](float x) mutable {
                    return std::abs(x - kReferenceFeature[i++ % kFeatureDim]) < 1e-6F;
                });
            minmax.scale(truth);
            minmax.scale(result);
            // [A] eq. 8 is about deformation: the reference itself has none.
            if (!is_reference) {
                fit.relative_squared_error_max =
                    std::max(fit.relative_squared_error_max, relative_squared_error(truth, result));
            }
            progress.update(static_cast<std::int64_t>(first + m + 1));
        }
    }
    fit.rms_error = rms.value();
    return fit;
}

}  // namespace

void setup_decode(CLI::App& app) {
    const auto options = std::make_shared<DecodeOptions>();
    CLI::App* command =
        app.add_subcommand("reconstruct", "Encode and decode shapes with a trained model");
    command->add_option("RUN", options->run, "Run folder or model file")->required();
    command->add_option("FEATURES", options->features, "Feature file of the same mesh")->required();
    command->add_option("-o,--output", options->output, "Folder to write the meshes to")
        ->required();
    command->add_option("--split", options->split, "Which shapes, as split for training")
        ->check(CLI::IsMember({"all", "train", "test"}))
        ->capture_default_str();
    command
        ->add_option("--levels", options->levels,
                     "Only the first levels, coarse to fine; 0 means all")
        ->check(CLI::NonNegativeNumber)
        ->capture_default_str();
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_json(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp reconstruct swing.run swing.safetensors -o decoded --split test");
    command->callback([options] { run_decode(*options); });
}

void run_decode(const DecodeOptions& options) {
    require_free_folder(options.output, options.common.force);
    TrainedRun run = open_run(options.run, kBatch);
    const int all_levels = static_cast<int>(run.model->level_sizes().size());
    if (options.levels > all_levels) {
        throw UsageError(
            fmt::format("--levels: got {}, the model has {}", options.levels, all_levels));
    }
    const int levels = options.levels == 0 ? all_levels : options.levels;
    const FeatureFile file(options.features);
    require_same_mesh(file.outline(), run, options.features);
    const std::vector<int> shapes = chosen_shapes(options, run, file.shape_count());
    create_folder(options.output);
    const Fit fit = decode_shapes(options, run, file, shapes, levels);
    if (options.common.json) {
        const nlohmann::ordered_json report{
            {"folder", options.output},
            {"split", options.split},
            {"shapes", shapes.size()},
            {"levels", levels},
            {"rms_error", fit.rms_error},
            {"relative_squared_error_max", fit.relative_squared_error_max}};
        fmt::print("{}\n", report.dump(2));
        return;
    }
    fmt::print("{}: {} meshes from {} level(s)\n", options.output, shapes.size(), levels);
    fmt::print("E_rms {:.3f} (x1000, unit ball), largest relative squared feature error {:.5f}\n",
               fit.rms_error, fit.relative_squared_error_max);
}

}  // namespace mscomp
