// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace mscomp {

/// Notes that the process shall stop because of `signal`; 0 takes it back. Async-signal-safe.
void request_stop(int signal) noexcept;
/// The signal that asked to stop, or 0. For whatever waits, perhaps forever.
int requested_stop() noexcept;

/// Whether the process was asked to stop.
bool interrupted() noexcept;
/// Throws Interrupted (exit code 128 + signal) with `message` if so.
void throw_if_interrupted(std::string_view message);

/// Notes that a job that keeps what it has reached, as training does, shall do so now and go on.
/// Async-signal-safe.
void request_save() noexcept;
/// Whether that was asked for since the last call.
bool take_save_request() noexcept;

/// Unlinks the temporary files of all outputs under way, for a process that is about to end without
/// destructors. Async-signal-safe.
void remove_temporary_files() noexcept;

}  // namespace mscomp
