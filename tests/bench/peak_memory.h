// SPDX-License-Identifier: MIT
#pragma once

#include <fstream>
#include <string>

namespace mscomp {

/// Most memory this process has held since the last forget_peak_memory, in MiB (Linux: VmHWM); 0
/// where the system does not say.
inline double peak_memory_mib() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;) {
        double kib = 0;
        if (word == "VmHWM:" && status >> kib) return kib / 1024;
    }
    return 0;
}

/// Begins a new peak, so that one process can time several cases.
inline void forget_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

}  // namespace mscomp
