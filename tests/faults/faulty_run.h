// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace mscomp::faults {

/// What a program came to.
struct Outcome {
    int code = -1;   // exit code, or
    int signal = 0;  // that ended it
    std::string out, err;
};

/// Runs a command line of one of the two programs in `folder`, with one thread and one call of the
/// system failing as tests/faults/shim.cpp says ("write:ENOSPC:7"; "" for none). What the shim
/// reports is in `report`. SIGALRM ends it after a minute.
Outcome run_with_fault(const std::string& folder, const std::vector<std::string>& arguments,
                       const std::string& fault, std::string& report);
Outcome run(const std::string& folder, const std::vector<std::string>& arguments);

/// Ends it with SIGKILL after `delay`, unless it has come to its end.
Outcome run_and_kill(const std::string& folder, const std::vector<std::string>& arguments,
                     std::chrono::microseconds delay);

/// How many calls of each class the command makes.
std::map<std::string, long> calls_of(const std::string& folder,
                                     const std::vector<std::string>& arguments);

/// The content of every file below `folder` by its path from there, without temporaries of the
/// programs and locks, and without what differs between two equal runs: the time in tables of
/// training, log.txt.
std::map<std::string, std::string> files_below(const std::string& folder);
/// Temporaries of the programs anywhere below.
std::vector<std::string> temporaries_below(const std::string& folder);

}  // namespace mscomp::faults
