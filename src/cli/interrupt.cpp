// SPDX-License-Identifier: MIT
#include "mscomp/cli/interrupt.h"

#include <unistd.h>

#include <csignal>
#include <string>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

volatile std::sig_atomic_t received_signal = 0;

// Only what is async-signal-safe.
extern "C" void note_signal(int signal) {
    if (received_signal != 0) _exit(128 + signal);
    received_signal = signal;
    constexpr char kNote[] = "\nstopping; once more to stop at once\n";
    // Nothing can be done about a message that cannot be written.
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kNote, sizeof kNote - 1);
}

}  // namespace

void watch_interrupts() {
    received_signal = 0;
    struct sigaction action = {};
    action.sa_handler = note_signal;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() { return received_signal != 0; }

int interrupt_signal() { return received_signal; }

void throw_if_interrupted(std::string_view message) {
    if (interrupted()) throw Interrupted(interrupt_signal(), std::string(message));
}

}  // namespace mscomp
