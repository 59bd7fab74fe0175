// SPDX-License-Identifier: MIT
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "mscomp/base/atomic_file.h"

namespace mscomp {

/// Where the programs were built.
inline std::string build_folder() {
    return std::filesystem::path(MSCOMP_BIN_DIR).parent_path().string();
}

struct ShellOutcome {
    int code = -1;
    std::string out, err;
};

/// Runs `command` by bash in `folder`, which also gets the files out and err.
inline ShellOutcome run_in(const std::string& folder, const std::string& command) {
    write_file(folder + "/command.sh", command + "\n");
    const std::string line = "cd '" + folder + "' && bash command.sh >out 2>err </dev/null";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder + "/out"),
            read_file(folder + "/err")};
}

inline bool is_installed(const std::string& program) {
    return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

inline std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
}

}  // namespace mscomp
