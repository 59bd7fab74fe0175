// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/program.h"

namespace CLI {
class App;
}

namespace mscomp {

struct ExtractCommand {
    std::vector<std::string> inputs;
    std::string list;  // a file that names the inputs, one per line, in its order
    std::string output;
    std::string reference = "0";  // index of a shape, or a mesh file
    std::string weights = "cotangent";
    bool align = true;
    CommonOptions common;
};
void setup_extract(CLI::App& app);
void run_extract(const ExtractCommand& options);

struct ReconstructCommand {
    std::string features;
    std::string output;
    std::string solver = "lossless";
    std::string handles;  // a JSON file of vertices and where they shall be
    std::string frames = ":";
    std::string format = "obj";
    bool keep_aligned = false;
    CommonOptions common;
};
void setup_reconstruct(CLI::App& app);
void run_reconstruct(const ReconstructCommand& options);

struct InfoCommand {
    std::string features;
    CommonOptions common;
};
void setup_info(CLI::App& app);
void run_info(const InfoCommand& options);

struct CheckCommand {
    std::vector<std::string> inputs;
    std::string list;
    std::string reference = "0";  // index of a shape, or a mesh file
    CommonOptions common;
};
void setup_check(CLI::App& app);
void run_check(const CheckCommand& options);

struct ConvertCommand {
    std::string input;
    std::string output;
    std::string to;         // format of the output; empty: by its extension
    std::string reference;  // a mesh file
    std::string weights = "authors";
    bool aligned = false;
    bool vertices = false;  // of a feature set, instead of the features
    CommonOptions common;
};
void setup_convert(CLI::App& app);
void run_convert(const ConvertCommand& options);

struct GenerateCommand {
    std::string name;
    std::string output;
    std::optional<int> frames, vertices;  // those of the generator where not given
    std::uint64_t seed = 0;
    std::optional<double> turns, tilt, noise, thickness;  // of `twist` alone
    CommonOptions common;
};
void setup_generate(CLI::App& app);
void run_generate(const GenerateCommand& options);

}  // namespace mscomp
