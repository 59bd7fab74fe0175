// SPDX-License-Identifier: MIT
#include "mscomp/base/readable_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "failed_call.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"

namespace mscomp {
namespace {

// A signal may reach another thread than the one that waits here, so it looks itself.
constexpr int kPatienceMilliseconds = 100;

// /dev/zero never ends, nor do some files that say that they are empty (/proc/self/pagemap); a pipe
// may bring a large mesh.
constexpr std::size_t kMostOfDevice = std::size_t{16} << 20;
constexpr std::size_t kMostOfOthers = std::size_t{1} << 30;

}  // namespace

ReadableFile::ReadableFile(std::string path) : path_(std::move(path)) {
    // O_NONBLOCK: opening a pipe would otherwise wait for its writer, deaf to signals.
    descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor_ < 0) fail(path_, "open", errno);
    struct stat info {};
    const int failed = ::fstat(descriptor_, &info) != 0 ? errno : 0;
    if (failed != 0 || S_ISDIR(info.st_mode)) {
        ::close(descriptor_);
        if (failed != 0) fail(path_, "read", failed);
        throw IoError(path_, "is a folder, wanted a file");
    }
    may_wait_ = !S_ISREG(info.st_mode);
    if (!may_wait_) size_ = at(info.st_size);
    most_ = S_ISCHR(info.st_mode) ? kMostOfDevice : std::max(size_, kMostOfOthers);
}

ReadableFile::~ReadableFile() { ::close(descriptor_); }

std::size_t ReadableFile::read(std::span<char> bytes) const {
    for (;;) {
        if (may_wait_) wait_for_data();
        const ssize_t got = ::read(descriptor_, bytes.data(), bytes.size());
        if (got >= 0) return counted(at(got));
        if (errno != EINTR && errno != EAGAIN) fail(path_, "read", errno);
    }
}

std::size_t ReadableFile::counted(std::size_t got) const {
    read_ += got;
    if (read_ > most_) {
        throw IoError(path_, fmt::format("gives more than {} MiB, which is taken from files only; "
                                         "copy it into one if it has an end",
                                         most_ >> 20U));
    }
    return got;
}

void ReadableFile::wait_for_data() const {
    for (;;) {
        if (const int signal = requested_stop(); signal != 0) {
            throw Interrupted(signal, path_ + ": interrupted while waiting for data");
        }
        pollfd waiting{descriptor_, POLLIN, 0};
        const int ready = ::poll(&waiting, 1, kPatienceMilliseconds);
        if (ready > 0) return;
        if (ready < 0 && errno != EINTR) fail(path_, "read", errno);
    }
}

}  // namespace mscomp
