// SPDX-License-Identifier: MIT
#include "file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

[[noreturn]] void fail(const std::string& path, const char* doing, int error_number) {
    throw IoError(path, std::string("cannot ") + doing + ": " +
                            std::generic_category().message(error_number));
}

struct Descriptor {
    int number;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

}  // namespace

FileBytes::FileBytes(const std::string& path) {
    const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.number < 0) fail(path, "open", errno);
    struct stat info {};
    if (::fstat(file.number, &info) != 0) fail(path, "read", errno);
    if (S_ISDIR(info.st_mode)) throw IoError(path, "is a folder, wanted a file");
    // One byte more than a file has: the read that finds its end then needs no more room. Pipes say
    // 0 and grow.
    std::size_t capacity = static_cast<std::size_t>(info.st_size) + 1;
    grow(capacity);
    for (;;) {
        if (size_ == capacity) grow(capacity = 2 * capacity + 65536);
        const ssize_t got = ::read(file.number, bytes_.get() + size_, capacity - size_);
        if (got == 0) return;
        if (got > 0) size_ += static_cast<std::size_t>(got);
        if (got < 0 && errno != EINTR) fail(path, "read", errno);
    }
}

void FileBytes::grow(std::size_t capacity) {
    auto larger = std::make_unique_for_overwrite<char[]>(capacity);
    if (size_ > 0) std::memcpy(larger.get(), bytes_.get(), size_);
    bytes_ = std::move(larger);
}

}  // namespace mscomp
