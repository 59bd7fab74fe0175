// SPDX-License-Identifier: MIT
#include "cli/program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "cli/signals.h"
#include "command_pages.h"
#include "mscomp/base/error.h"
#include "mscomp/base/nearest_name.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

int fail(const CLI::App& app, ExitCode code, const std::string& message) {
    std::cout.flush();
    fmt::print(stderr, "{}: error: {}\n", app.get_name(), message);
    return static_cast<int>(code);
}

/// The first word that is no option where a command was wanted, or "".
std::string unknown_command(const CLI::App& app) {
    const std::vector<std::string> words = app.remaining();
    const auto found =
        std::ranges::find_if(words, [](const std::string& word) { return !word.starts_with('-'); });
    return found == words.end() ? "" : *found;
}

std::vector<std::string> command_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        names.push_back(command->get_name());
    }
    return names;
}

/// "", or what is wrong with `text`.
std::string is_thread_count(const std::string& text) {
    constexpr int kMost = 1024;
    int count = 0;
    const char* end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, count);
    if (error == std::errc{} && at == end && 0 <= count && count <= kMost) return "";
    return fmt::format("got {}, wanted 0 to {} (0: one per processor)", text, kMost);
}

int answer(const CLI::App& app, const CLI::ParseError& error) {
    // Help and version are answers, everything else is a mistake in the command line.
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return app.exit(error);
    const auto chosen = app.get_subcommands();
    const std::string unknown = chosen.empty() ? unknown_command(app) : "";
    if (!unknown.empty()) {
        return fail(
            app, ExitCode::usage,
            fmt::format("there is no command '{}'; the nearest one is '{}'\nSee {} --help", unknown,
                        nearest_name(unknown, command_names(app)), app.get_name()));
    }
    const std::string command = chosen.empty() ? "" : " " + chosen.front()->get_name();
    return fail(app, ExitCode::usage,
                fmt::format("{}\nSee {}{} --help", error.what(), app.get_name(), command));
}

void flush_results() {
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        throw IoError("standard output", std::generic_category().message(errno));
    }
}

}  // namespace

void wait_asleep(char** argv) {
    for (const char* variable : {"OMP_WAIT_POLICY", "GOMP_SPINCOUNT"}) {
        if (std::getenv(variable) != nullptr) return;
    }
    // The OpenMP library reads its environment before main: only a new start can tell it.
    setenv("GOMP_SPINCOUNT", "20000", 1);
    execv("/proc/self/exe", argv);
    // Where that is not possible the program runs as it is.
}

void setup_program(CLI::App& app) {
    app.set_version_flag("--version", app.get_name() + " " + MSCOMP_VERSION);
    app.require_subcommand(1);
    add_command_pages(app);
}

int run_program(CLI::App& app, int argc, const char* const* argv) {
    try {
        watch_interrupts();
        app.parse(argc, argv);
        flush_results();
        return static_cast<int>(ExitCode::ok);
    } catch (const CLI::ParseError& error) {
        return answer(app, error);
    } catch (const Error& error) {
        return fail(app, error.exit_code(), error.what());
    } catch (const std::bad_alloc&) {
        return fail(app, ExitCode::bug, "not enough memory for this input");
    } catch (const std::exception& error) {
        // What is longer than a buffer fails while it is printed, with an exception of fmt's own.
        if (std::ferror(stdout) != 0) {
            const IoError unwritten("standard output", std::generic_category().message(errno));
            return fail(app, unwritten.exit_code(), unwritten.what());
        }
        return fail(app, ExitCode::bug,
                    fmt::format("this is a bug, please report it: {}", error.what()));
    } catch (...) {
        return fail(app, ExitCode::bug, "this is a bug, please report it: unknown exception");
    }
}

void add_quiet(CLI::App& command, CommonOptions& options) {
    command.add_flag("--quiet", options.quiet, "Print results and errors only");
}

void add_json(CLI::App& command, CommonOptions& options) {
    command.add_flag("--json", options.json, "Print the results as one JSON object");
}

void add_force(CLI::App& command, CommonOptions& options) {
    command.add_flag("--force", options.force, "Replace output that exists");
}

void add_threads(CLI::App& command, CommonOptions& options) {
    command
        .add_option_function<int>(
            "--threads",
            [&options](int count) {
                options.threads = count;
                set_thread_count(count);
            },
            "Number of threads, 0 for one per processor; results do not depend on it")
        ->check(is_thread_count)
        ->default_str("0");
}

void set_example(CLI::App& command, const std::string& example) {
    command.footer("Example:\n  " + example);
}

}  // namespace mscomp
