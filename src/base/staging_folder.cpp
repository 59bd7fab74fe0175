// SPDX-License-Identifier: MIT
#include "staging_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "failed_call.h"
#include "in_place_exchange.h"
#include "mscomp/base/error.h"
#include "mscomp/base/outputs.h"
#include "temporary_place.h"

namespace fs = std::filesystem;

namespace mscomp {
namespace {

bool is_folder(const std::string& path) {
    struct stat info {};
    return ::stat(path.c_str(), &info) == 0 && S_ISDIR(info.st_mode);
}

}  // namespace

StagingFolder::StagingFolder(std::string folder, Place place) : folder_(std::move(folder)) {
    const std::string parent = folder_of(folder_);
    remove_dead_temporaries(parent);
    remove_dead_temporaries(folder_);
    if (place == Place::beside) create_folder(parent, folder_);
    if (place == Place::inside || !make_beside(parent)) {
        create_folder(folder_);
        is_inside_ = true;
        if (const int failed = make_in(folder_, "")) fail(folder_, "write into the folder", failed);
    }
}

StagingFolder::~StagingFolder() {
    remove_staging(path_);
    if (descriptor_ >= 0) ::close(descriptor_);
}

/// False where an existing folder has to be filled from within.
bool StagingFolder::make_beside(const std::string& parent) {
    const int failed = make_in(parent, fs::path(folder_).filename().string());
    if (failed != 0) {
        if (is_folder(folder_)) return false;
        fail(folder_, "create the folder", failed);
    }
    if (can_move_into_folder()) return true;
    remove_staging(path_);
    ::close(std::exchange(descriptor_, -1));
    return false;
}

/// 0, or the system's reason why nothing can be made there.
int StagingFolder::make_in(const std::string& parent, const std::string& name) {
    for (int attempt = 0;; ++attempt) {
        path_ = parent + "/" + temporary_name(name);
        if (::mkdir(path_.c_str(), 0777) != 0) {
            if (errno == EEXIST) continue;
            return errno;
        }
        descriptor_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
        if (descriptor_ < 0 && errno != ENOENT) return give_up(errno);
        const bool is_ours = descriptor_ >= 0 && try_lock(descriptor_) != Lock::refused &&
                             !is_gone(descriptor_, path_);
        // Somebody who cleans up may have been quicker than our lock, but not every time.
        if (is_ours || attempt == kQuickerThanUs) break;
        if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
    }
    for (const std::string& part : {new_files(path_), old_files(path_)}) {
        if (::mkdir(part.c_str(), 0777) != 0) return give_up(errno);
    }
    return 0;
}

int StagingFolder::give_up(int failed) {
    remove_staging(path_);
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
    return failed;
}

/// Whether what is moved from here to there arrives: not across mounts, even of one file system.
bool StagingFolder::can_move_into_folder() const {
    if (!is_folder(folder_)) return true;
    const std::string probe = old_files(path_);
    const std::string there = folder_ + "/" + temporary_name("");
    if (std::rename(probe.c_str(), there.c_str()) != 0) return false;
    return std::rename(there.c_str(), probe.c_str()) == 0;
}

}  // namespace mscomp
