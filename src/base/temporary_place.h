// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace mscomp {

/// A name for what is under way and becomes `name`: ".NAME.mscompPID-N", another one at each call.
/// Hidden, so that nobody takes it for a mesh of the folder; a long NAME is cut.
std::string temporary_name(const std::string& name);
/// Whether temporary_name can have made it, in whatever process.
bool is_temporary_name(std::string_view name);

/// The folder that `path` lies in, "." if it names none.
std::string folder_of(const std::string& path);
/// What is to be replaced where a file shall be `path`: the file that a link leads to, so that the
/// link stays. Throws IoError for a link to nowhere and where the system does not say.
std::string behind_links(const std::string& path);
/// FOLDER/NAME.
std::string path_in(const std::string& folder, const std::string& name);

/// What is under way is locked by who writes it, until that process ends, however it does.
enum class Lock { taken, refused, unsupported };
/// Locks what the descriptor stands for. Some file systems cannot.
Lock try_lock(int descriptor);
/// How often what we have just made can be gone before we have locked it. A file system that says
/// so each time has names that cannot be trusted.
constexpr int kQuickerThanUs = 20;
/// Whether the descriptor stands for what is called `path` now.
bool is_named(int descriptor, const std::string& path);
/// Whether it is known not to: not where the system does not say.
bool is_gone(int descriptor, const std::string& path);

/// Removes from `folder` what processes that are gone left of files and of output folders, the
/// latter undone where they were half exchanged (in_place_exchange.h). What somebody may still be
/// writing, and what cannot be locked, stays. Failures are no errors: it is tried again by the
/// next.
void remove_dead_temporaries(const std::string& folder);
/// The same, only once per folder and process: for who writes many files into one folder.
void remove_dead_temporaries_once(const std::string& folder);

/// Names that were given in `folder` reach the disk. Throws IoError naming `path`.
void sync_folder(const std::string& folder, const std::string& path);

}  // namespace mscomp
