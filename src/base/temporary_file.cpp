// SPDX-License-Identifier: MIT
#include "temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/output_folder.h"
#include "mscomp/base/outputs.h"
#include "temporary_place.h"

namespace mscomp {
namespace {

std::string reason(int error_number) { return std::generic_category().message(error_number); }

/// Who could read and write the file that is replaced can read and write the new one, as far as
/// this user may give it away.
void keep_mode_and_owner(int descriptor, const std::string& target) {
    struct stat info {};
    if (::stat(target.c_str(), &info) != 0) return;
    const mode_t all = S_IRWXU | S_IRWXG | S_IRWXO;
    // Until it has its owner nobody else shall read it.
    ::fchmod(descriptor, info.st_mode & S_IRWXU);
    const bool is_owned = ::fchown(descriptor, info.st_uid, info.st_gid) == 0 ||
                          ::fchown(descriptor, static_cast<uid_t>(-1), info.st_gid) == 0;
    // What the group might do was for that group only.
    ::fchmod(descriptor, info.st_mode & (is_owned ? all : all & ~static_cast<mode_t>(S_IRWXG)));
}

/// A new file that this process has locked, or -1.
int open_new_beside(const std::string& target, std::string& temporary) {
    const std::filesystem::path place(target);
    for (int attempt = 0;; ++attempt) {
        temporary = folder_of(target) + "/" + temporary_name(place.filename().string());
        const int descriptor =
            ::open(temporary.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        // A name may be taken by what a killed program with the same number left.
        if (descriptor < 0 && errno != EEXIST) return -1;
        if (descriptor < 0) continue;
        // Somebody who cleans up may have been quicker than our lock, but not every time.
        const bool is_ours =
            try_lock(descriptor) != Lock::refused && !is_gone(descriptor, temporary);
        if (is_ours || attempt == kQuickerThanUs) return descriptor;
        ::close(descriptor);
    }
}

}  // namespace

void refuse_special_target(const std::string& path) {
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) return;
    if (S_ISDIR(info.st_mode)) throw IoError(path, "is a folder, cannot write a file there");
    if (!S_ISREG(info.st_mode)) throw IoError(path, "is not a regular file, will not replace it");
}

TemporaryFile::TemporaryFile(std::string target) : target_(behind_links(target)) {
    refuse_special_target(target_);
    create_folder(folder_of(target_), shown());
    remove_dead_temporaries_once(folder_of(target_));
    descriptor_ = open_new_beside(target_, path_);
    if (descriptor_ < 0) throw IoError(shown(), "cannot create: " + reason(errno));
    name_.emplace(path_);
    keep_mode_and_owner(descriptor_, target_);
}

TemporaryFile::~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!path_.empty()) ::unlink(path_.c_str());
}

void TemporaryFile::fail(std::string_view doing) const {
    throw IoError(shown(),
                  fmt::format("cannot {}: {}; nothing was changed there", doing, reason(errno)));
}

void TemporaryFile::fail_comparison() const {
    throw IoError(shown(),
                  "what was read back differs from what was written; the disk or its "
                  "connection is faulty; nothing was changed there");
}

void TemporaryFile::reserve(std::uint64_t size) const {
    if (size == 0) return;
    const auto length = static_cast<off_t>(size);
    if (::fallocate(descriptor_, 0, 0, length) == 0) return;
    // Not every file system can; the room is then claimed as the file is written.
    if (errno != EOPNOTSUPP && errno != ENOSYS && errno != EINVAL) fail("write");
    if (::ftruncate(descriptor_, length) != 0) fail("write");
}

void TemporaryFile::write(std::uint64_t offset, std::span<const std::byte> bytes) const {
    while (!bytes.empty()) {
        const ssize_t done =
            ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) fail("write");
        offset += static_cast<std::uint64_t>(done);
        bytes = bytes.subspan(at(done));
    }
}

std::size_t TemporaryFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
    std::size_t count = 0;
    while (count < bytes.size()) {
        const ssize_t done = ::pread(descriptor_, bytes.data() + count, bytes.size() - count,
                                     static_cast<off_t>(offset + count));
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) fail("read back");
        if (done == 0) break;
        count += at(done);
    }
    return count;
}

void TemporaryFile::sync() const {
    if (::fsync(descriptor_) != 0) fail("write to disk");
}

void TemporaryFile::take_place() {
    // Locked until it has its name: nobody shall take it for what a killed program left.
    const int lock = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
    const bool is_closed = ::close(std::exchange(descriptor_, -1)) == 0;
    const bool is_renamed = is_closed && std::rename(path_.c_str(), target_.c_str()) == 0;
    const int failed = errno;
    if (lock >= 0) ::close(lock);
    errno = failed;
    if (!is_closed) fail("close");
    if (!is_renamed) fail("rename the finished file");
    name_.reset();
    path_.clear();
    sync_folder(folder_of(target_), shown());
}

std::string TemporaryFile::shown() const { return final_name(target_); }

}  // namespace mscomp
