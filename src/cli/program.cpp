// SPDX-License-Identifier: MIT
#include "cli/program.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "cli/process.h"
#include "cli/say.h"
#include "cli/signals.h"
#include "command_pages.h"
#include "mscomp/base/error.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/nearest_name.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/parsed_number.h"

namespace mscomp {
namespace {

int code_of(ExitCode code) { return static_cast<int>(code); }

int fail(const CLI::App& app, ExitCode code, std::string_view message) noexcept {
    say("{}: error: {}\n", app.get_name(), message);
    return code_of(code);
}

int fail_usage(const CLI::App& app, std::string_view message, std::string_view command) {
    say("{}: error: {}\nSee {}{} --help\n", app.get_name(), message, app.get_name(), command);
    return code_of(ExitCode::usage);
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
    const std::optional<int> count = parsed_number<int>(text);
    if (count && 0 <= *count && *count <= kMost) return "";
    return fmt::format("got {}, wanted 0 to {} (0: one per processor)", text, kMost);
}

int answer(const CLI::App& app, const CLI::ParseError& error) {
    // Help and version are answers, everything else is a mistake in the command line.
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
        std::ostringstream text, nothing;
        app.exit(error, text, nothing);
        print_lines(text.str());
        flush_results();
        return code_of(ExitCode::ok);
    }
    const auto chosen = app.get_subcommands();
    const std::string unknown = chosen.empty() ? unknown_command(app) : "";
    if (!unknown.empty()) {
        return fail_usage(app,
                          fmt::format("there is no command '{}'; the nearest one is '{}'", unknown,
                                      nearest_name(unknown, command_names(app))),
                          "");
    }
    return fail_usage(app, error.what(), chosen.empty() ? "" : " " + chosen.front()->get_name());
}

/// What memory is limited to by the shell, if it is: "; ulimit -v allows 200 MiB".
std::string memory_limit() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "";
    return fmt::format("; ulimit -v allows {} MiB", limit.rlim_cur >> 20U);
}

int run_command(CLI::App& app, int argc, const char* const* argv) {
    try {
        watch_interrupts();
        app.parse(std::max(argc, 1), argv);
        flush_results();
        return code_of(ExitCode::ok);
    } catch (const CLI::ParseError& error) {
        return answer(app, error);
    }
}

/// The code of an exception, whose message is printed. To be called where one was caught.
int code_of_failure(const CLI::App& app) {
    try {
        throw;
    } catch (const Error& error) {
        return fail(app, error.exit_code(), error.what());
    } catch (const std::system_error& error) {
        return fail(app, ExitCode::io,
                    fmt::format("the system refused: {}{}", error.what(), memory_limit()));
    } catch (const std::bad_alloc&) {
        return fail(app, ExitCode::io, "not enough memory for this input" + memory_limit());
    } catch (const std::length_error&) {
        return fail(app, ExitCode::io, "not enough memory for this input");
    } catch (const std::exception& error) {
        return fail(app, ExitCode::bug,
                    fmt::format("this is a bug, please report it: {}", error.what()));
    } catch (...) {
        return fail(app, ExitCode::bug, "this is a bug, please report it: unknown exception");
    }
}

std::atomic<bool> is_memory_missing{false};

[[noreturn]] void note_missing_memory() {
    is_memory_missing = true;
    throw std::bad_alloc();
}

/// Destructors of libraries may take memory (those of nlohmann-json and Ceres do), and where there
/// is none the language ends the process, often without a word of what was thrown. It ends as it
/// would have.
[[noreturn]] void end_without_memory() noexcept {
    remove_temporary_files();
    try {
        if (std::current_exception()) throw;
    } catch (const std::bad_alloc&) {
        is_memory_missing = true;  // of who allocates otherwise, such as Eigen
    } catch (...) {
        write_all(STDERR_FILENO, "error: this is a bug, please report it\n");
    }
    if (is_memory_missing) {
        write_all(STDERR_FILENO, "error: not enough memory\n");
        ::_exit(code_of(ExitCode::io));
    }
    std::abort();  // its traces stay
}

}  // namespace

void setup_program(CLI::App& app) {
    app.set_version_flag("--version", app.get_name() + " " + MSCOMP_VERSION);
    app.require_subcommand(1);
    add_command_pages(app);
}

int run_program(CLI::App& app, int argc, const char* const* argv) {
    try {
        return run_command(app, argc, argv);
    } catch (...) {
        return code_of_failure(app);
    }
}

int run_main(const Program& program, int argc, char** argv) {
    prepare_process(argv);
    std::set_new_handler(note_missing_memory);
    std::set_terminate(end_without_memory);
    try {
        CLI::App app(program.description, program.name);
        setup_program(app);
        for (void (*setup)(CLI::App&) : program.commands) setup(app);
        return run_program(app, argc, argv);
    } catch (...) {
        // Only memory can be missing here, for the message too.
        write_all(STDERR_FILENO, "error: not enough memory\n");
        return code_of(ExitCode::io);
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
