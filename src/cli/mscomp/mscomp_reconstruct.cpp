// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/progress.h"
#include "cli/say.h"
#include "cli/shape_files.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "mscomp/eval/measures.h"
#include "mscomp/run/fits.h"
#include "mscomp/run/run_folder.h"
#include "mscomp/run/shape_decoder.h"
#include "mscomp_commands.h"

namespace mscomp {
namespace {

/// How far what comes out is from what went in.
struct FitErrors {
    explicit FitErrors(const std::vector<Point>& reference) : rms(reference) {}
    RmsError rms;
    std::optional<double> relative_squared_error_max;  // none where no shape has one
};

void add(FitErrors& errors, const ShapeDecoder& decoder, int shape, const DecodedShape& decoded) {
    errors.rms.add(decoder.truth(shape), decoded.vertices);
    if (const auto error = decoder.relative_squared_error_of(shape, decoded)) {
        double& most = errors.relative_squared_error_max.emplace(
            errors.relative_squared_error_max.value_or(*error));
        most = std::max(most, *error);
    }
}

struct DecodedErrors {
    FitErrors encoded, written;
};

DecodedErrors decode_shapes(const DecodeOptions& options, TrainedRun& run, const FeatureFile& file,
                            const std::vector<int>& shapes, int levels) {
    const TriangleMesh& reference = run.context().reference;
    const Fit fit = fits_of_run(options.fit, run).front();
    const std::vector<std::string> names = shape_file_names(file.outline().names);
    std::size_t written = 0;
    const auto check_stop = [&] {
        throw_if_interrupted(fmt::format("interrupted; nothing was changed in {}", options.output));
    };
    OutputFolder output(options.output);
    ShapeDecoder decoder(run, file, check_stop);
    DecodedErrors errors{FitErrors(reference.vertices), FitErrors(reference.vertices)};
    Progress progress("reconstruct", static_cast<std::int64_t>(shapes.size()),
                      progress_options(options.common.quiet));
    while (written < shapes.size()) {
        const std::span<const int> group = std::span<const int>(shapes).subspan(
            written, std::min<std::size_t>(ShapeDecoder::kGroup, shapes.size() - written));
        const std::vector<DecodedShape> plain = decoder.encode(group, levels);
        const std::vector<DecodedShape> result = fitted(fit, decoder, group, plain);
        for (std::size_t m = 0; m < group.size(); ++m) {
            check_stop();
            const int shape = group[m];
            add(errors.encoded, decoder, shape, plain[m]);
            add(errors.written, decoder, shape, result[m]);
            write_obj(output.path(names[static_cast<size_t>(shape)] + ".obj"),
                      run.context().whole(result[m].vertices));
            file.forget(shape);
            progress.update(static_cast<std::int64_t>(++written));
        }
    }
    output.commit();
    return errors;
}

void print_report(const DecodeOptions& options, std::size_t shapes, int levels,
                  const DecodedErrors& errors) {
    const FitErrors& written = errors.written;
    const bool is_plain = options.fit == name_of(Fit::features);
    const double plain = errors.encoded.rms.value();
    if (options.common.json) {
        nlohmann::ordered_json report{{"folder", options.output},
                                      {"split", options.split},
                                      {"shapes", shapes},
                                      {"levels", levels},
                                      {"fit", options.fit},
                                      {"rms_error", written.rms.value()},
                                      {"relative_squared_error_max", nullptr}};
        if (const auto& most = written.relative_squared_error_max) {
            report["relative_squared_error_max"] = *most;
        }
        if (!is_plain) report["rms_error_features"] = plain;
        print_lines(json_text(report, 2) + "\n");
        return;
    }
    print_out("{}: {} meshes from {} level(s)\n", options.output, shapes, levels);
    print_out("E_rms {:.3f} (x1000, unit ball)", written.rms.value());
    if (const auto& most = written.relative_squared_error_max) {
        print_out(", largest relative squared feature error {:.5f}", *most);
    }
    print_out("\n");
    if (!is_plain) {
        print_out("codes fitted to the {}; E_rms {:.3f} with those of the encoder\n",
                  options.fit == name_of(Fit::codes) ? "features" : "vertices", plain);
    }
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
        ->add_option(
            "--fit", options->fit,
            "Codes of the encoder (features), or from there fitted to the features (codes) or "
            "to the vertices")
        ->check(CLI::IsMember(fit_names()))
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
    require_extension(options.output, "a folder", {});
    require_free_folder(options.output, options.common.force);
    require_apart(files_of_kind(options.output, {"obj"}),
                  {model_path(options.run), options.features});
    TrainedRun run = open_run(options.run, ShapeDecoder::kGroup);
    const int all_levels = static_cast<int>(run.model->levels().size());
    if (options.levels > all_levels) {
        throw UsageError(
            fmt::format("--levels: got {}, the model has {}", options.levels, all_levels));
    }
    const int levels = options.levels == 0 ? all_levels : options.levels;
    if (options.fit != name_of(Fit::features) && levels < all_levels) {
        throw UsageError(
            fmt::format("--levels: got --fit {}, which fits the codes of all levels", options.fit));
    }
    const FeatureFile file(options.features);
    require_mesh_of(run, file);
    const std::vector<int> shapes = shapes_of_split(run, file, options.split);
    print_report(options, shapes.size(), levels, decode_shapes(options, run, file, shapes, levels));
}

}  // namespace mscomp
