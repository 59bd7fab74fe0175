// SPDX-License-Identifier: MIT
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>

namespace mscomp::fuzz {

/// For readers that want a file: one in memory, filled anew for every input.
class MemoryFile {
  public:
    MemoryFile() : number_(::memfd_create("input", MFD_CLOEXEC)) {
        if (number_ < 0) throw std::runtime_error("no file in memory");
    }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    ~MemoryFile() { ::close(number_); }

    /// The name under which it can be opened as long as the object lives.
    std::string filled_with(std::span<const std::byte> bytes) const {
        const auto size = static_cast<ssize_t>(bytes.size());
        if (::ftruncate(number_, 0) != 0 ||
            ::pwrite(number_, bytes.data(), bytes.size(), 0) != size) {
            throw std::runtime_error("cannot fill a file in memory");
        }
        return "/proc/self/fd/" + std::to_string(number_);
    }

  private:
    int number_;
};

}  // namespace mscomp::fuzz
