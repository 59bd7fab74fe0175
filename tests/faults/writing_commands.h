// SPDX-License-Identifier: MIT
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace mscomp::faults {

using Arguments = std::vector<std::string>;

/// A command that writes, in a folder that has what it reads: meshes/, features.safetensors,
/// config.yaml, a trained.run, one begun.run of fewer epochs, sweep.yaml.
struct WritingCommand {
    std::string name;
    Arguments arguments;
    /// Commands that make what was there before; empty: nothing was.
    std::vector<Arguments> before;
    /// Output that grows step by step: what lies there in between is neither old nor new, but the
    /// same command ends where it would have ended.
    bool goes_on = false;
};

inline std::ostream& operator<<(std::ostream& stream, const WritingCommand& command) {
    return stream << command.name;
}

/// Every command that writes: with nothing there before, and with older output and --force.
std::vector<WritingCommand> writing_commands();

/// Makes what they read. Throws std::runtime_error with what a command said if one fails.
void prepare_inputs(const std::string& folder);

}  // namespace mscomp::faults
