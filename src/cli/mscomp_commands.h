// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/cli/program.h"

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
    int tile = 300;    // pixels of one picture in the contact sheet
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
    std::string fit = "features";  // features | vertices
    CommonOptions common;
};
void setup_decode(CLI::App& app);
void run_decode(const DecodeOptions& options);

struct EvaluateOptions {
    std::string run;
    std::string features;         // empty: the file the run was trained on
    std::string split;            // all | train | test; empty: test where the run has such shapes
    std::vector<int> handles;     // how many, for E_rms against their number
    std::vector<int> components;  // likewise
    std::string fit = "both";     // features | vertices | both
    std::string order = "auto";   // sequence | set | auto: by the run's split
    int worst = 3;                // how many of the worst shapes are named and drawn
    std::string units;            // CSV of true weights; empty: none
    std::string output;           // folder for table.csv and errors.png; empty: none
    CommonOptions common;
};
void setup_evaluate(CLI::App& app);
void run_evaluate(const EvaluateOptions& options);

}  // namespace mscomp
