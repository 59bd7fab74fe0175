// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace mscomp {

/// Starts the program anew, once, so that OpenMP threads with nothing to do soon sleep instead of
/// keeping a processor busy, which on a shared machine stops everybody. Leaves OMP_WAIT_POLICY and
/// GOMP_SPINCOUNT alone where they are set. Call it first in main.
void wait_asleep(char** argv);

/// What both programs share: name, version, one command at a time.
void setup_program(CLI::App& app);

/// Parses the command line and runs the command chosen, with signals watched and the results on
/// stdout flushed. Returns the exit code (base/error.h); what went wrong is one line on stderr,
/// "acapfeat: error: ...". The only place that catches and the only one that knows exit codes.
int run_program(CLI::App& app, int argc, const char* const* argv);

/// Options that mean the same in every command.
struct CommonOptions {
    bool quiet = false;
    bool json = false;
    bool force = false;
    int threads = 0;
};
void add_quiet(CLI::App& command, CommonOptions& options);
void add_json(CLI::App& command, CommonOptions& options);
void add_force(CLI::App& command, CommonOptions& options);
void add_threads(CLI::App& command, CommonOptions& options);

/// Ends the help of a command with a line that can be pasted.
void set_example(CLI::App& command, const std::string& example);

}  // namespace mscomp
