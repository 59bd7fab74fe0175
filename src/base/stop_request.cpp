// SPDX-License-Identifier: MIT
#include "mscomp/base/stop_request.h"

#include <atomic>

namespace mscomp {
namespace {

std::atomic<int> stop_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

}  // namespace

void request_stop(int signal) noexcept { stop_signal = signal; }

int requested_stop() noexcept { return stop_signal; }

}  // namespace mscomp
