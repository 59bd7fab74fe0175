// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/program.h"

namespace CLI {
class App;
}

namespace mscomp {

struct InitOptions {
    std::string kind;
};
void setup_init(CLI::App& app);
void run_init(const InitOptions& options);

struct TrainOptions {
    std::string config;
    std::string output;  // run folder; empty: the name of the config with .run
    std::vector<std::string> overrides;
    bool resume = false;
    CommonOptions common;
};
void setup_train(CLI::App& app);
void run_train(const TrainOptions& options);

struct RefineOptions {
    std::string run;
    std::string output;  // run folder
    std::vector<std::string> overrides;
    bool resume = false;
    CommonOptions common;
};
void setup_refine(CLI::App& app);
void run_refine(const RefineOptions& options);

struct UnitsOptions {
    std::string input;       // feature file, run folder or model file
    std::string output;      // run folder
    int components = 0;      // 0: as many as are found
    bool positions = false;  // instead of features
    std::vector<std::string> overrides;
    bool resume = false;
    CommonOptions common;
};
void setup_units(CLI::App& app);
void run_units(const UnitsOptions& options);

struct RunInfoOptions {
    std::string run;
    CommonOptions common;
};
void setup_run_info(CLI::App& app);
void run_run_info(const RunInfoOptions& options);

struct ExportOptions {
    std::string run;
    std::string output;
    bool all = false;  // dropped components too
    int tile = 240;    // pixels of one picture in the overview
    std::string up;    // empty: guessed
    std::string view;  // empty: chosen for each component
    CommonOptions common;
};
void setup_export(CLI::App& app);
void run_export(const ExportOptions& options);

struct DecodeOptions {
    std::string run;
    std::string features;
    std::string output;
    std::string split = "all";     // all | train | test
    int levels = 0;                // 0: all
    std::string fit = "features";  // features | codes | vertices
    CommonOptions common;
};
void setup_decode(CLI::App& app);
void run_decode(const DecodeOptions& options);

struct SynthesizeOptions {
    std::string run;
    std::vector<std::string> weights;  // ID=W
    std::string output;                // mesh; empty: none
    std::string sheet;                 // picture; empty: none
    std::vector<std::string> components;
    int strongest = 3;  // where no components are named
    int level = -1;     // of them; -1: any
    std::vector<double> sheet_weights{0.3, 0.7, 1.1};
    int tile = 300;
    bool list = false;
    CommonOptions common;
};
void setup_synthesize(CLI::App& app);
void run_synthesize(const SynthesizeOptions& options);

struct SampleOptions {
    std::string run;
    std::string output;
    int count = 12;
    std::uint64_t seed = 0;
    std::string from;  // prior | fitted; empty: by the kind
    bool independent = false;
    std::string format = "obj";
    int tile = 300;
    CommonOptions common;
};
void setup_sample(CLI::App& app);
void run_sample(const SampleOptions& options);

struct EvaluateOptions {
    std::string run;
    std::string features;         // empty: the file the run was trained on
    std::string split;            // all | train | test; empty: test where the run has such shapes
    std::vector<int> handles;     // how many, for E_rms against their number
    std::vector<int> components;  // likewise
    std::string fit = "both";     // features | codes | vertices | both | all
    bool kept = false;            // only what the filter keeps acts
    std::string order = "auto";   // sequence | set | auto: by the run's split
    int worst = 3;                // how many of the worst shapes are named and drawn
    std::string units;            // CSV of true weights; empty: none
    std::string truth;            // truth.json of a generated set; empty: none
    std::string output;           // folder for table.csv and errors.png; empty: none
    CommonOptions common;
};
void setup_evaluate(CLI::App& app);
void run_evaluate(const EvaluateOptions& options);

struct SweepCommand {
    std::string sweep;
    std::string output;
    std::vector<std::string> overrides;
    CommonOptions common;
};
void setup_sweep(CLI::App& app);
void run_sweep_command(const SweepCommand& command);

}  // namespace mscomp
