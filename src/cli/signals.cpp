// SPDX-License-Identifier: MIT
#include "cli/signals.h"

#include <unistd.h>

#include <array>
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
        if (signal == SIGXCPU || nanoseconds_now() - first_signal_at < kSameWish) return;
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

extern "C" void note_save_request(int) { request_save(); }

// Job systems warn by most of these before they kill; a terminal that is closed sends SIGHUP.
constexpr std::array kStops{SIGINT, SIGTERM, SIGHUP, SIGUSR2, SIGXCPU};

bool is_ignored(int signal) {
    struct sigaction action = {};
    return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

void watch_interrupts() {
    request_stop(0);
    struct sigaction action = {};
    action.sa_handler = note_signal;
    // None interrupts the handling of another.
    sigemptyset(&action.sa_mask);
    for (const int signal : kStops) sigaddset(&action.sa_mask, signal);
    action.sa_flags = SA_RESTART;
    for (const int signal : kStops) {
        const bool is_nohup = signal == SIGHUP && is_ignored(signal);
        if (!is_nohup) sigaction(signal, &action, nullptr);
    }
    action.sa_handler = note_save_request;
    sigaction(SIGUSR1, &action, nullptr);
    // A file that grows beyond its limit is a failing write, with a name and a reason.
    std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace mscomp
