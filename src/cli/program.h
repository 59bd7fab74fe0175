// SPDX-License-Identifier: MIT
#pragma once

#include <initializer_list>
#include <string>

namespace CLI {
class App;
}

namespace mscomp {

/// What both programs share: name, version, one command at a time.
void setup_program(CLI::App& app);

/// Parses the command line and runs the command chosen, with signals watched and the results on
/// stdout flushed. Returns the exit code (base/error.h); what went wrong is one line on stderr,
/// "acapfeat: error: ...". The only place that catches and the only one that knows exit codes.
int run_program(CLI::App& app, int argc, const char* const* argv);

/// One of the two programs.
struct Program {
    const char* name;
    const char* description;
    std::initializer_list<void (*)(CLI::App&)> commands;  // each adds one
};

/// All that main does: prepares the process, makes the commands, runs the one chosen. Returns the
/// exit code and throws nothing.
int run_main(const Program& program, int argc, char** argv);

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
