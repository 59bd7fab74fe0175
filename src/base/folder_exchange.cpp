// SPDX-License-Identifier: MIT
#include "folder_exchange.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "folder_entries.h"
#include "in_place_exchange.h"
#include "temporary_place.h"

namespace fs = std::filesystem;

namespace mscomp {
namespace {

/// Whether we, and so probably the shell that started us, are in the folder or below: it must stay
/// where it is.
bool is_current(const std::string& folder) {
    std::error_code error;
    const fs::path here = fs::current_path(error), there = fs::canonical(folder, error);
    if (error) return false;
    return std::mismatch(there.begin(), there.end(), here.begin(), here.end()).first == there.end();
}

bool same_file(const std::string& a, const std::string& b) {
    struct stat one {
    }, other{};
    return ::lstat(a.c_str(), &one) == 0 && ::lstat(b.c_str(), &other) == 0 &&
           one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

/// Entries of `folder` that stay although they are none of the new ones.
std::optional<std::vector<std::string>> others_in(const std::string& folder,
                                                  const std::set<std::string>& known) {
    std::optional<std::vector<std::string>> others = names_in(folder);
    if (others) std::erase_if(*others, [&](const auto& name) { return known.contains(name); });
    return others;
}

/// Gives the others a second name in the new folder. Folders cannot have one.
bool link_others(const std::string& folder, const std::string& fresh,
                 const std::set<std::string>& known) {
    const std::optional<std::vector<std::string>> others = others_in(folder, known);
    return others && std::ranges::all_of(*others, [&](const std::string& name) {
               return ::linkat(AT_FDCWD, (folder + "/" + name).c_str(), AT_FDCWD,
                               (fresh + "/" + name).c_str(), 0) == 0;
           });
}

/// What came to the old folder, or was replaced in it, behind our back comes along.
void fetch_latecomers(const std::string& old_folder, const std::string& folder,
                      const std::set<std::string>& known) {
    const std::optional<std::vector<std::string>> others = others_in(old_folder, known);
    if (!others) return;
    for (const std::string& name : *others) {
        const std::string from = path_in(old_folder, name), to = path_in(folder, name);
        if (!same_file(from, to)) std::rename(from.c_str(), to.c_str());
    }
}

void sync_both(const std::string& folder) {
    sync_folder(folder, folder);
    sync_folder(folder_of(folder), folder);
}

}  // namespace

FolderLock::FolderLock(const std::string& folder) {
    for (int attempt = 0;; ++attempt) {
        descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (descriptor_ < 0) return;
        while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
        }
        // It may have been exchanged while we waited.
        if (is_named(descriptor_, folder) || attempt == kQuickerThanUs) return;
        ::close(std::exchange(descriptor_, -1));
    }
}

FolderLock::~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

bool exchange_folder(const std::string& folder, const std::string& staging,
                     const std::vector<std::string>& names, const std::set<std::string>& dropped) {
    const std::string fresh = new_files(staging);
    std::error_code error;
    if (!fs::exists(folder, error)) {
        if (std::rename(fresh.c_str(), folder.c_str()) != 0) return false;
        sync_both(folder);
        return true;
    }
    std::set<std::string> known(names.begin(), names.end());
    known.insert(dropped.begin(), dropped.end());
    keep_modes_and_owners(folder, staging, names);
    if (is_current(folder) || !link_others(folder, fresh, known) ||
        !take_mode_and_owner(folder, fresh) ||
        ::renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, folder.c_str(), RENAME_EXCHANGE) != 0) {
        return false;
    }
    fetch_latecomers(fresh, folder, known);
    sync_both(folder);
    return true;
}

}  // namespace mscomp
