// SPDX-License-Identifier: MIT
#include "mscomp/base/interruption.h"

#include <atomic>
#include <string>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

std::atomic<int> stop_signal{0};
std::atomic<bool> is_save_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);
static_assert(std::atomic<int>::is_always_lock_free);

}  // namespace

void request_stop(int signal) noexcept { stop_signal = signal; }

int requested_stop() noexcept { return stop_signal; }

void request_save() noexcept { is_save_requested = true; }

bool take_save_request() noexcept { return is_save_requested.exchange(false); }

bool interrupted() noexcept { return requested_stop() != 0; }

void throw_if_interrupted(std::string_view message) {
    if (interrupted()) throw Interrupted(requested_stop(), std::string(message));
}

}  // namespace mscomp
