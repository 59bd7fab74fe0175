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
    /// Several files of the user's names: no system renames two at once, so that one killed between
    /// leaves both kinds, and a list by which the next start mends it.
    bool is_pair = false;
    /// HDF5's own library ends the process where it cannot allocate as it starts (libhdf5 1.10,
    /// H5P__init_package): nothing of ours runs then.
    bool needs_memory = false;
};

inline std::ostream& operator<<(std::ostream& stream, const WritingCommand& command) {
    return stream << command.name;
}

/// Every command that writes: with nothing there before, and with older output and --force.
std::vector<WritingCommand> writing_commands();

/// Makes what they read. Throws std::runtime_error with what a command said if one fails.
void prepare_inputs(const std::string& folder);

}  // namespace mscomp::faults
