// SPDX-License-Identifier: MIT
#include "run_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/failed_call.h"
#include "base/temporary_place.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/outputs.h"

namespace mscomp {
namespace {

std::string this_process() {
    std::array<char, 256> host{};
    if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
    return fmt::format("process {} on {}", ::getpid(), host.data());
}

std::string holder(int descriptor) {
    std::array<char, 512> text{};
    const ssize_t count = ::pread(descriptor, text.data(), text.size(), 0);
    return count > 0 ? std::string(text.data(), at(count)) : "another process";
}

}  // namespace

RunLock::RunLock(const std::string& folder, std::string file)
    : folder_(folder), path_(std::move(file)) {
    std::error_code error;
    has_made_folder_ = !std::filesystem::exists(folder, error);
    create_folder(folder);
    for (int attempt = 0;; ++attempt) {
        open();
        const Lock lock = try_lock(descriptor_);
        if (lock == Lock::refused) {
            const std::string who = holder(descriptor_);
            ::close(descriptor_);
            throw IoError(folder,
                          fmt::format("{} is writing there; wait until it ends, or stop it", who));
        }
        // Who had it may have removed it just now.
        if (is_named(descriptor_, path_) || attempt == kQuickerThanUs) break;
        ::close(std::exchange(descriptor_, -1));
    }
    claim();
}

RunLock::~RunLock() {
    if (!is_kept_ && has_made_file_) ::unlink(path_.c_str());
    if (!is_kept_ && has_made_folder_) ::rmdir(folder_.c_str());
    ::close(descriptor_);
}

void RunLock::open() {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    has_made_file_ = descriptor_ >= 0;
    if (descriptor_ < 0 && errno == EEXIST) {
        descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    }
    if (descriptor_ < 0) fail(path_, "open", errno);
}

/// For the message of who comes next; that message is all that is lost if it cannot be written.
void RunLock::claim() const {
    const std::string text = this_process();
    if (::ftruncate(descriptor_, 0) != 0) return;
    [[maybe_unused]] const ssize_t written = ::pwrite(descriptor_, text.data(), text.size(), 0);
}

}  // namespace mscomp
