// SPDX-License-Identifier: MIT
#include "mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "failed_call.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

struct Descriptor {
    int number;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

}  // namespace

MappedFile::MappedFile(std::string path) : path_(std::move(path)) {
    // O_NONBLOCK: opening a pipe must not wait for somebody to write into it.
    const Descriptor file{::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file.number < 0) fail(path_, "open", errno);
    struct stat info {};
    if (::fstat(file.number, &info) != 0) fail(path_, "read", errno);
    if (S_ISDIR(info.st_mode)) throw IoError(path_, "is a folder, wanted a file");
    if (!S_ISREG(info.st_mode)) throw IoError(path_, "is not a regular file, cannot be mapped");
    const auto size = at(info.st_size);
    if (size == 0) return;
    void* start = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.number, 0);
    if (start == MAP_FAILED) fail(path_, "map into memory", errno);
    bytes_ = {static_cast<const std::byte*>(start), size};
}

void MappedFile::forget(std::size_t begin, std::size_t end) const {
    const auto page = at(::sysconf(_SC_PAGESIZE));
    begin -= begin % page;
    end -= end % page;
    if (begin >= end) return;
    ::madvise(const_cast<std::byte*>(bytes_.data()) + begin, end - begin, MADV_DONTNEED);
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace mscomp
