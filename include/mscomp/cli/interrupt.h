// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace mscomp {

/// From here on the first SIGINT or SIGTERM only raises a flag that commands look at, so they can
/// finish what they are writing; one that comes a second or more later removes temporary files and
/// ends the process at once with 128 + signal. Forgets an earlier signal.
void watch_interrupts();

/// Whether a signal has come in.
bool interrupted();
/// SIGINT, SIGTERM, or 0 while there was none.
int interrupt_signal();

/// Throws Interrupted (exit code 130 or 143) with `message` if a signal has come in.
void throw_if_interrupted(std::string_view message);

}  // namespace mscomp
