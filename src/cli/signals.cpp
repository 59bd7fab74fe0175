// SPDX-License-Identifier: MIT
#include "cli/signals.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <ctime>

#include "mscomp/base/interruption.h"

namespace mscomp {
namespace {

// Job systems send a signal to the process and to its group, timeout(1) twice in a row: what comes
// this soon after the first is no second wish.
constexpr std::int64_t kSameWish = 1'000'000'000;

std::atomic<std::int64_t> first_signal_at{0};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t nanoseconds_now() {
    struct timespec now = {};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

// Only what is async-signal-safe.
extern "C" void note_signal(int signal) {
    const int error_number = errno;
    if (requested_stop() != 0) {
        if (nanoseconds_now() - first_signal_at < kSameWish) return;
        remove_temporary_files();
        _exit(128 + signal);
    }
    first_signal_at = nanoseconds_now();
    request_stop(signal);
    constexpr char kNote[] = "\nstopping; once more to stop at once\n";
    // Nothing can be done about a message that cannot be written.
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kNote, sizeof kNote - 1);
    errno = error_number;
}

}  // namespace

void watch_interrupts() {
    request_stop(0);
    struct sigaction action = {};
    action.sa_handler = note_signal;
    // Neither interrupts the handling of the other.
    sigemptyset(&action.sa_mask);
    sigaddset(&action.sa_mask, SIGINT);
    sigaddset(&action.sa_mask, SIGTERM);
    action.sa_flags = SA_RESTART;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

}  // namespace mscomp
