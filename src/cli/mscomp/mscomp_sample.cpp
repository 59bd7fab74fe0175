// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/number_of.h"
#include "cli/progress.h"
#include "cli/say.h"
#include "cli/seed_option.h"
#include "mscomp/base/error.h"
#include "mscomp/base/json_text.h"
#include "mscomp/base/kept_inputs.h"
#include "mscomp/base/outputs.h"
#include "mscomp/model/code_statistics.h"
#include "mscomp/report/sample_shapes.h"
#include "mscomp/run/run_folder.h"
#include "mscomp_commands.h"

namespace mscomp {
namespace {

CodeDistribution distribution_of(const SampleOptions& options, const TrainedRun& run) {
    const std::string from =
        !options.from.empty() ? options.from : (run.model->has_prior() ? "prior" : "fitted");
    if (from == "fitted") {
        return options.independent ? CodeDistribution::independent : CodeDistribution::fitted;
    }
    if (!run.model->has_prior()) {
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
    return CodeDistribution::prior;
}

std::string name_of(CodeDistribution distribution) {
    return distribution == CodeDistribution::prior ? "prior" : "fitted";
}

SampleShapesOptions sampling_of(const SampleOptions& options, const TrainedRun& run) {
    SampleShapesOptions sampling;
    sampling.distribution = distribution_of(options, run);
    sampling.count = options.count;
    sampling.seed = options.seed;
    sampling.format = options.format;
    sampling.tile = options.tile;
    sampling.title = fmt::format("{} of {}, {}{}, seed {}", number_of_shapes(options.count),
                                 std::filesystem::path(run.context().source).stem().string(),
                                 name_of(sampling.distribution),
                                 options.independent ? ", independent" : "", options.seed);
    return sampling;
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
    require_extension(options.output, "a folder", {});
    require_free_folder(options.output, options.common.force);
    require_apart(files_of_kind(options.output, {options.format, "csv", "png"}),
                  {model_path(options.run)});
    TrainedRun run = open_run(options.run);
    SampleShapesOptions sampling = sampling_of(options, run);
    Progress progress("sample", options.count, progress_options(options.common.quiet));
    sampling.on_progress = [&](std::int64_t done, std::int64_t) { progress.update(done); };
    const std::vector<std::string> files = sample_shapes(run, options.output, sampling);
    const double deviation = code_deviation(run.file.codes());
    if (options.common.json) {
        const nlohmann::ordered_json report{{"run", options.run},
                                            {"kind", run.config.kind},
                                            {"from", name_of(sampling.distribution)},
                                            {"independent", options.independent},
                                            {"seed", options.seed},
                                            {"code_deviation", deviation},
                                            {"codes", options.output + "/codes.csv"},
                                            {"overview", options.output + "/overview.png"},
                                            {"files", files}};
        print_lines(json_text(report, 2) + "\n");
        return;
    }
    const bool prior = sampling.distribution == CodeDistribution::prior;
    print_out("{}: {} from the {}, codes.csv and overview.png\n", options.output,
              number_of_shapes(options.count), prior ? "prior" : "Gaussian of the training codes");
    if (prior) {
        print_out("codes of the prior deviate by 1, those of the training shapes by {:.3g}\n",
                  deviation);
    }
}

}  // namespace mscomp
