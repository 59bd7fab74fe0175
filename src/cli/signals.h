// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// From here on the first SIGINT or SIGTERM only raises a flag that commands look at, so they can
/// finish what they are writing; one that comes a second or more later removes temporary files and
/// ends the process at once with 128 + signal. Forgets an earlier signal.
void watch_interrupts();

}  // namespace mscomp
