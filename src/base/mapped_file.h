// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace mscomp {

/// A regular file mapped read-only for as long as the object lives; page-aligned.
class MappedFile {
  public:
    /// Throws IoError with the system's reason.
    explicit MappedFile(std::string path);
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;
    ~MappedFile();

    const std::string& path() const { return path_; }
    std::span<const std::byte> bytes() const { return bytes_; }

    /// The pages of bytes [begin, end) need not stay in memory; they come back when they are used.
    void forget(std::size_t begin, std::size_t end) const;

  private:
    std::string path_;
    std::span<const std::byte> bytes_;
};

}  // namespace mscomp
