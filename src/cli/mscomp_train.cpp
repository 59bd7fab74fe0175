// SPDX-License-Identifier: MIT
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>

#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/feature_scaler.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/cli/config_file.h"
#include "mscomp/cli/interrupt.h"
#include "mscomp/cli/outputs.h"
#include "mscomp/cli/progress.h"
#include "mscomp/cli/split.h"
#include "mscomp_commands.h"
#include "nn/trainer.h"
#include "peak_memory.h"
#include "trained_run.h"
#include "training_log.h"

namespace mscomp {
namespace {

/// Everything a training run works on, in the order it is made.
struct TrainingSetup {
    nn::Config config;
    FeatureFile features;
    FeatureScaler scaler;
    nn::ModelContext context;
    std::unique_ptr<NormalizedGeodesics> distances;
    std::unique_ptr<nn::Model<float>> model;
};

std::string run_folder(const TrainOptions& options) {
    if (!options.output.empty()) return options.output;
    return std::filesystem::path(options.config).replace_extension(".run").string();
}

nn::Config effective_config(const TrainOptions& options) {
    nn::Config config = read_config(options.config, options.overrides);
    const std::string folder = std::filesystem::path(options.config).parent_path().string();
    // The run folder lies elsewhere: what was relative to the config has to be found from there.
    const auto anchored = [&](const std::string& path) {
        return std::filesystem::absolute(path_from(folder, path)).lexically_normal().string();
    };
    config.data.features = anchored(config.data.features);
    if (!config.data.split.path.empty()) config.data.split.path = anchored(config.data.split.path);
    return config;
}

/// The configuration as far as it shapes the result: how long and how often saved may change.
std::string comparable(nn::Config config) {
    config.train.epochs = 1;
    config.train.plateau_epochs = 0;
    config.train.plateau_gain = 0;
    config.train.checkpoint_every = 1;
    config.filter = {};
    return write_config(config, false);
}

void require_same_config(const nn::ModelFile& file, const nn::Config& config,
                         const std::string& run) {
    if (comparable(parse_config(file.context().config, checkpoint_path(run))) ==
        comparable(config)) {
        return;
    }
    throw UsageError(fmt::format(
        "{} was trained with another configuration (see {}); --resume may only change "
        "train.epochs, train.plateau_epochs, train.plateau_gain, train.checkpoint_every "
        "and filter",
        run, config_path(run)));
}

TrainingSetup prepare(const nn::Config& config) {
    TrainingSetup setup{config, FeatureFile(config.data.features), {}, {}, nullptr, nullptr};
    const FeatureSet& outline = setup.features.outline();
    const Split split = resolve_split(config.data.split, outline.shape_count(), "");
    if (split.train.empty()) throw UsageError("data.split leaves no shape to train on");
    const FeatureRanges ranges(setup.features, split.train);
    setup.scaler = ranges.scaler(
        config.data.center == nn::Scaling::minmax ? FeatureCenter::minmax
                                                  : FeatureCenter::reference,
        config.data.scale == nn::Scale::shared ? FeatureScale::shared : FeatureScale::separate);
    const FeatureScaler minmax = ranges.scaler(FeatureCenter::minmax);
    setup.context.minmax_offset = minmax.offset;
    setup.context.minmax_factor = minmax.factor;
    if (std::ranges::all_of(setup.scaler.factor, [](double f) { return f == 0; })) {
        throw UsageError(fmt::format("{}: the training shapes do not differ from the reference",
                                     config.data.features));
    }

    HeatGeodesics geodesics(outline.reference);
    const GeodesicNormalizer normalizer = geodesic_normalizer(geodesics);
    setup.distances =
        std::make_unique<NormalizedGeodesics>(std::move(geodesics), normalizer.largest_distance);
    setup.context.config = write_config(config, false);
    setup.context.source = config.data.features;
    setup.context.source_hash = setup.features.data_hash();
    setup.context.weights = outline.weights;
    setup.context.reference = outline.reference;
    setup.context.offset = setup.scaler.offset;
    setup.context.factor = setup.scaler.factor;
    setup.context.largest_distance = normalizer.largest_distance;
    setup.context.largest_distance_exact = normalizer.exact;
    setup.context.train_shapes = split.train;
    setup.context.test_shapes = split.test;
    setup.model =
        make_model(config, outline.reference, *setup.distances, nn::ModelUse::training,
                   std::min(config.train.batch,
                            nn::epoch_size(config.train, static_cast<int>(split.train.size()),
                                           outline.vertex_count())));
    return setup;
}

void describe(const TrainingSetup& setup, const std::string& run, LineFile& log) {
    log.append(fmt::format("{}: {} shapes ({} train), {} vertices; run folder {}",
                           setup.config.data.features, setup.features.shape_count(),
                           setup.context.train_shapes.size(), setup.features.vertex_count(), run));
    log.append(fmt::format("largest geodesic distance {:.6g} ({})", setup.context.largest_distance,
                           setup.context.largest_distance_exact ? "exact" : "lower bound"));
    const std::vector<std::string>& names = setup.features.outline().names;
    for (const FeatureExtreme& extreme : setup.scaler.extremes) {
        log.append(
            fmt::format("extreme of the training features: channel {} is {:.6g} in {} at vertex {}",
                        extreme.channel, extreme.value, names[at(extreme.shape)], extreme.vertex));
    }
}

/// Saves run state: rows and log first, so that the checkpoint never claims more than they hold.
void save(const std::string& run, TrainingSetup& setup, nn::Trainer& trainer, MetricsFile& metrics,
          LineFile& log) {
    metrics.sync();
    nn::write_model(checkpoint_path(run), *setup.model, setup.context, trainer.state(),
                    trainer.codes());
    log.append(fmt::format("saved at epoch {}, step {}, loss {:.6g}; peak memory {:.0f} MiB",
                           trainer.state().epoch, trainer.state().step, trainer.state().total,
                           peak_memory_mib()));
    log.sync();
}

/// As a shell reads it back.
std::string quoted(const std::string& text) {
    const bool is_plain =
        !text.empty() &&
        text.find_first_not_of(
            "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%") ==
            std::string::npos;
    if (is_plain) return text;
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

std::string how_to_go_on(const TrainOptions& options, const std::string& run,
                         const nn::Trainer& trainer) {
    std::string command = fmt::format("mscomp train {} -o {}", quoted(options.config), quoted(run));
    for (const std::string& set : options.overrides) command += " --set " + quoted(set);
    return fmt::format("interrupted after epoch {}, saved; go on with: {} --resume",
                       trainer.state().epoch, command);
}

void train(const TrainOptions& options, const std::string& run, TrainingSetup& setup,
           nn::Trainer& trainer, LineFile& log) {
    constexpr std::chrono::seconds kLongestUnsaved{120};
    const nn::TrainConfig& plan = setup.config.train;
    MetricsFile metrics(metrics_path(run), setup.model->term_names(), trainer.state().epoch);
    Progress progress("train", plan.epochs,
                      progress_options(options.common.quiet, trainer.state().epoch));
    // From the first moment on the folder holds what belongs together, even if nothing else comes.
    if (trainer.state().step == 0) save(run, setup, trainer, metrics, log);
    auto saved_at = std::chrono::steady_clock::now();
    while (!trainer.is_over()) {
        const nn::EpochReport report = trainer.run_epoch();
        metrics.append(report);
        progress.update(report.state.epoch, describe_loss(report, metrics.term_names()));
        const auto now = std::chrono::steady_clock::now();
        const bool is_due = report.state.epoch % plan.checkpoint_every == 0 || trainer.is_over() ||
                            now - saved_at > kLongestUnsaved;
        if (is_due || interrupted()) {
            save(run, setup, trainer, metrics, log);
            saved_at = std::chrono::steady_clock::now();
        }
        throw_if_interrupted(how_to_go_on(options, run, trainer));
    }
    if (trainer.state().is_plateau) {
        log.append(
            fmt::format("plateau: the last {} epochs lowered the error by less than {} of it",
                        plan.plateau_epochs, plan.plateau_gain));
    }
}

}  // namespace

void setup_train(CLI::App& app) {
    const auto options = std::make_shared<TrainOptions>();
    CLI::App* command = app.add_subcommand("train", "Learn components from a feature file");
    command->add_option("CONFIG", options->config, "YAML configuration (see mscomp init)")
        ->required();
    command->add_option("-o,--output", options->output,
                        "Run folder to write [name of CONFIG with .run]");
    command
        ->add_option("--set", options->overrides,
                     "key=value that replaces what CONFIG says, e.g. train.epochs=500; repeatable")
        ->allow_extra_args(false);
    command->add_flag("--resume", options->resume,
                      "Go on from the last checkpoint of the run folder, if there is one");
    add_force(*command, options->common);
    add_quiet(*command, options->common);
    add_threads(*command, options->common);
    set_example(*command, "mscomp train config.yaml -o swing.run --set train.epochs=500");
    command->callback([options] { run_train(*options); });
}

void run_train(const TrainOptions& options) {
    const std::string run = run_folder(options);
    const nn::Config config = effective_config(options);
    std::optional<nn::ModelFile> earlier;
    if (options.resume && std::filesystem::exists(checkpoint_path(run))) {
        earlier.emplace(checkpoint_path(run));
        require_same_config(*earlier, config, run);
    } else {
        require_free_folder(run, options.common.force);
    }
    TrainingSetup setup = prepare(config);
    if (earlier && earlier->context().source_hash != setup.context.source_hash) {
        throw UsageError(
            fmt::format("{} was trained on other features than {} holds now; --resume "
                        "needs the same",
                        run, config.data.features));
    }

    create_folder(run);
    LineFile log(log_path(run));
    const std::time_t now = std::time(nullptr);
    log.append(
        fmt::format("{:%Y-%m-%d %H:%M:%S} UTC  mscomp train {}", fmt::gmtime(now), options.config));
    describe(setup, run, log);
    write_file(config_path(run), write_config(config, true));
    const nn::ScaledFeatures features{setup.features, setup.scaler.offset, setup.scaler.factor};
    nn::Trainer trainer(*setup.model, setup.config, features, setup.context.train_shapes);
    if (earlier) {
        earlier->load(*setup.model);
        trainer.resume(earlier->state());
        log.append(fmt::format("resumed at epoch {}", trainer.state().epoch));
    } else {
        trainer.start();
    }
    train(options, run, setup, trainer, log);
    if (!options.report) return;
    fmt::print("{}: {} epochs, {} steps, loss {:.6g}; peak memory {:.0f} MiB\n", run,
               trainer.state().epoch, trainer.state().step, trainer.state().total,
               peak_memory_mib());
}

}  // namespace mscomp
