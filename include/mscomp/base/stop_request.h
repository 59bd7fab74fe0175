// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// Notes that the process shall stop because of `signal`; 0 takes it back. Async-signal-safe.
void request_stop(int signal) noexcept;
/// The signal that asked to stop, or 0. For whatever waits, perhaps forever.
int requested_stop() noexcept;

/// Unlinks the temporary files of all outputs under way, for a process that is about to end without
/// destructors. Async-signal-safe.
void remove_temporary_files() noexcept;

}  // namespace mscomp
