// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// From here on the first SIGINT, SIGTERM, SIGHUP (unless it is ignored, as under nohup), SIGUSR2
/// or SIGXCPU only raises a flag that commands look at, so they can finish what they are writing;
/// one that comes a second or more later removes temporary files and ends the process at once with
/// 128 + signal, SIGXCPU apart, which comes every second. SIGUSR1 asks to save and go on
/// (take_save_request). SIGXFSZ is ignored: the write then fails. Forgets an earlier signal.
void watch_interrupts();

}  // namespace mscomp
