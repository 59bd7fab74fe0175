// SPDX-License-Identifier: MIT
#include "faults/writing_commands.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "faults/faulty_run.h"

namespace mscomp::faults {
namespace {

constexpr const char* kConfig =
    "model:\n"
    "  kind: stacked-attention\n"
    "  levels:\n"
    "    - {components: 2, sparsity_range: 0.5}\n"
    "data:\n"
    "  features: features.safetensors\n"
    "  split: {train: every, step: 2}\n"
    "train: {epochs: 3, checkpoint_every: 1, fill_up_to: 0}\n";

/// Two epochs of each stage.
constexpr const char* kFit =
    "model:\n"
    "  kind: multiscale\n"
    "  global_components: 1\n"
    "  levels:\n"
    "    - {components: 2, sparsity_range: 0.5, max_support: 0.5}\n"
    "data:\n"
    "  features: features.safetensors\n"
    "  split: {train: every, step: 2}\n"
    "train: {rounds: 2, epochs: 4, checkpoint_every: 1, select: false, fill_up_to: 5}\n";

constexpr const char* kSweep =
    "config: config.yaml\n"
    "points:\n"
    "  grid:\n"
    "    train.learning_rate: [0.003, 0.001]\n";

void put(const std::string& path, const char* text) { std::ofstream(path) << text; }

/// The command as it is, and with --force over what others made.
void add_both(std::vector<WritingCommand>& all, const std::string& name, Arguments arguments,
              std::vector<Arguments> before) {
    all.push_back({name + "New", arguments, {}});
    arguments.emplace_back("--force");
    all.push_back({name + "Again", arguments, std::move(before)});
}

}  // namespace

std::vector<WritingCommand> writing_commands() {
    std::vector<WritingCommand> all;
    add_both(
        all, "Generate",
        {"acapfeat", "generate", "twist", "-o", "out", "--frames", "3", "--vertices", "100"},
        {{"acapfeat", "generate", "twist", "-o", "out", "--frames", "5", "--vertices", "100"}});
    add_both(all, "Extract", {"acapfeat", "extract", "meshes", "-o", "out.safetensors"},
             {{"acapfeat", "extract", "meshes", "-o", "out.safetensors", "--weights", "uniform"}});
    add_both(
        all, "Reconstruct", {"acapfeat", "reconstruct", "features.safetensors", "-o", "out"},
        {{"acapfeat", "reconstruct", "features.safetensors", "-o", "out", "--solver", "poisson"}});
    for (const std::string out :
         {"out.npz", "out.npy", "out.h5", "LOGRNEWout.txt", "out.safetensors", "out"}) {
        const Arguments uniform{"acapfeat",  "extract", "meshes", "-o", "uniform.safetensors",
                                "--weights", "uniform"};
        const std::string kind = out == "out"           ? "Meshes"
                                 : out.starts_with("L") ? "Text"
                                                        : out.substr(4);
        Arguments now{"acapfeat", "convert", "features.safetensors", out}, earlier = now;
        earlier[2] = "uniform.safetensors";
        if (out == "out") {
            for (Arguments* each : {&now, &earlier}) each->insert(each->end(), {"--to", "ply"});
        }
        if (kind == "h5" || kind == "Meshes") earlier.emplace_back("--aligned");
        add_both(all, "Convert" + kind, now, {uniform, earlier});
    }
    add_both(all, "Train", {"mscomp", "train", "config.yaml", "-o", "out.run"},
             {{"mscomp", "train", "config.yaml", "-o", "out.run", "--set", "train.epochs=2",
               "--set", "train.learning_rate=0.001"}});
    all.push_back({"Resume",
                   {"mscomp", "train", "config.yaml", "-o", "out.run", "--resume"},
                   {{"mscomp", "train", "config.yaml", "-o", "out.run", "--set", "train.epochs=1"}},
                   true});
    add_both(all, "Fit", {"mscomp", "train", "fit.yaml", "-o", "out.run"},
             {{"mscomp", "train", "fit.yaml", "-o", "out.run", "--set", "train.epochs=3"}});
    add_both(all, "Refine",
             {"mscomp", "refine", "trained.run", "-o", "out.run", "--set", "train.epochs=2"},
             {{"mscomp", "refine", "trained.run", "-o", "out.run", "--set", "train.epochs=1"}});
    add_both(all, "Units", {"mscomp", "units", "many.safetensors", "--positions", "-o", "out.run"},
             {{"mscomp", "units", "many.safetensors", "--positions", "-o", "out.run",
               "--components", "1"}});
    all.push_back({"SweepNew", {"mscomp", "sweep", "sweep.yaml", "-o", "out"}, {}, true});
    all.push_back({"SweepAgain",
                   {"mscomp", "sweep", "sweep.yaml", "-o", "out"},
                   {{"mscomp", "sweep", "sweep.yaml", "-o", "out", "--set", "train.epochs=2"}},
                   true});
    add_both(
        all, "Export", {"mscomp", "export-components", "trained.run", "-o", "out", "--tile", "64"},
        {{"mscomp", "export-components", "trained.run", "-o", "out", "--all", "--tile", "80"}});
    add_both(all, "Evaluate", {"mscomp", "evaluate", "trained.run", "-o", "out", "--handles", "3"},
             {{"mscomp", "evaluate", "trained.run", "-o", "out", "--split", "train"}});
    add_both(all, "Decode",
             {"mscomp", "reconstruct", "trained.run", "features.safetensors", "-o", "out"},
             {{"mscomp", "reconstruct", "trained.run", "features.safetensors", "-o", "out",
               "--split", "test"}});
    add_both(all, "Sample",
             {"mscomp", "sample", "trained.run", "-n", "2", "-o", "out", "--tile", "64"},
             {{"mscomp", "sample", "trained.run", "-n", "3", "-o", "out", "--tile", "64", "--seed",
               "5"}});
    add_both(all, "Synthesize",
             {"mscomp", "synthesize", "trained.run", "--weight", "0=1", "-o", "out.obj", "--sheet",
              "out.png", "--strongest", "1", "--tile", "64"},
             {{"mscomp", "synthesize", "trained.run", "--weight", "0=0.5", "-o", "out.obj",
               "--sheet", "out.png", "--strongest", "2", "--tile", "64"}});
    for (WritingCommand& command : all) {
        for (const char* training : {"Train", "Fit", "Refine", "Units"}) {
            command.goes_on = command.goes_on || command.name.starts_with(training);
        }
        command.is_pair =
            command.name.starts_with("ConvertText") || command.name.starts_with("Synthesize");
        if (command.name.starts_with("Converth5")) command.needs_memory = true;
    }
    return all;
}

void prepare_inputs(const std::string& folder) {
    put(folder + "/config.yaml", kConfig);
    put(folder + "/fit.yaml", kFit);
    put(folder + "/sweep.yaml", kSweep);
    const std::vector<Arguments> commands{
        {"acapfeat", "generate", "twist", "-o", "meshes", "--frames", "4", "--vertices", "100",
         "--turns", "0.4"},
        {"acapfeat", "extract", "meshes", "-o", "features.safetensors"},
        {"acapfeat", "generate", "twist", "-o", "many", "--frames", "14", "--vertices", "100"},
        {"acapfeat", "extract", "many", "-o", "many.safetensors"},
        {"mscomp", "train", "config.yaml", "-o", "trained.run"}};
    for (const Arguments& arguments : commands) {
        const Outcome outcome = run(folder, arguments);
        if (outcome.code != 0) throw std::runtime_error(arguments[1] + ": " + outcome.err);
    }
    std::filesystem::remove_all(folder + "/many");
}

}  // namespace mscomp::faults
