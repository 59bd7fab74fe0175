// SPDX-License-Identifier: MIT
#include "faults/faulty_run.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <sstream>
#include <thread>

#include "base/temporary_folder.h"

namespace fs = std::filesystem;

namespace mscomp::faults {
namespace {

constexpr unsigned kSeconds = 60;

[[noreturn]] void become(const std::string& folder, const std::vector<std::string>& arguments,
                         const std::string& fault, const std::string& beside) {
    const std::string program = std::string(MSCOMP_BIN_DIR) + "/" + arguments.front();
    std::vector<char*> argv;
    for (const std::string& argument : arguments) {
        argv.push_back(const_cast<char*>(argument.c_str()));
    }
    argv.push_back(nullptr);
    if (::chdir(folder.c_str()) != 0) ::_exit(126);
    const int out = ::open((beside + ".out").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    const int err = ::open((beside + ".err").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(err, STDERR_FILENO);
    ::setenv("GOMP_SPINCOUNT", "20000", 1);  // else the program would start itself anew
    ::setenv("OMP_NUM_THREADS", "1", 1);
    ::setenv("OPENBLAS_NUM_THREADS", "1", 1);
    ::setenv("MSCOMP_FAULT_SCOPE", folder.c_str(), 1);
    ::setenv("MSCOMP_FAULT_REPORT", (beside + ".report").c_str(), 1);
    if (!fault.empty()) ::setenv("MSCOMP_FAULT", fault.c_str(), 1);
    ::setenv("LD_PRELOAD", MSCOMP_FAULT_SHIM, 1);
    ::alarm(kSeconds);
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
}

/// Lines without their last cell, where that is a time.
std::string without_times(const std::string& text) {
    static const std::regex kLastCell(R"(,[^,\n]*\n)");
    return std::regex_replace(text, kLastCell, "\n");
}

bool is_temporary(const std::string& name) {
    static const std::regex kTemporary(R"(\..*\.?mscomp\d+-\d+)");
    return std::regex_match(name, kTemporary);
}

bool is_in_temporary(const fs::path& path) {
    return std::any_of(path.begin(), path.end(),
                       [](const fs::path& part) { return is_temporary(part.string()); });
}

/// Where what it says and what the shim reports is kept.
std::string beside(const std::string& folder) { return folder + "-said"; }

pid_t start(const std::string& folder, const std::vector<std::string>& arguments,
            const std::string& fault) {
    fs::remove(beside(folder) + ".report");
    const pid_t child = ::fork();
    if (child == 0) become(folder, arguments, fault, beside(folder));
    return child;
}

Outcome end_of(pid_t child, const std::string& folder) {
    int status = 0;
    ::waitpid(child, &status, 0);
    Outcome outcome;
    if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
    outcome.out = TemporaryFolder::content(beside(folder) + ".out");
    outcome.err = TemporaryFolder::content(beside(folder) + ".err");
    return outcome;
}

}  // namespace

Outcome run_with_fault(const std::string& folder, const std::vector<std::string>& arguments,
                       const std::string& fault, std::string& report) {
    const Outcome outcome = end_of(start(folder, arguments, fault), folder);
    report = TemporaryFolder::content(beside(folder) + ".report");
    return outcome;
}

Outcome run_and_kill(const std::string& folder, const std::vector<std::string>& arguments,
                     std::chrono::microseconds delay) {
    const pid_t child = start(folder, arguments, "");
    std::this_thread::sleep_for(delay);
    ::kill(child, SIGKILL);
    return end_of(child, folder);
}

Outcome run(const std::string& folder, const std::vector<std::string>& arguments) {
    std::string ignored;
    return run_with_fault(folder, arguments, "", ignored);
}

std::map<std::string, long> calls_of(const std::string& folder,
                                     const std::vector<std::string>& arguments) {
    std::string report;
    run_with_fault(folder, arguments, "", report);
    std::map<std::string, long> counts;
    std::istringstream lines(report);
    std::string call;
    for (long count = 0; lines >> call >> count;) counts[call] = count;
    return counts;
}

std::map<std::string, std::string> files_below(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        const fs::path path = entry.path().lexically_relative(folder);
        const std::string name = path.filename().string();
        if (!entry.is_regular_file() || is_in_temporary(path)) continue;
        if (name.ends_with("lock") || name == "log.txt") continue;
        std::string text = TemporaryFolder::content(entry.path().string());
        // Their last column is how long it took.
        if (name == "metrics.csv" || name == "table.csv") text = without_times(text);
        if (name == "table.md") continue;
        files[path.string()] = std::move(text);
    }
    return files;
}

std::vector<std::string> temporaries_below(const std::string& folder) {
    std::vector<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (is_temporary(entry.path().filename().string())) found.push_back(entry.path().string());
    }
    return found;
}

}  // namespace mscomp::faults
