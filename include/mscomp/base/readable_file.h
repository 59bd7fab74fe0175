// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace mscomp {

/// A file to be read from its beginning to its end, once. Of a pipe or a device it waits for data,
/// but not beyond a request to stop, and takes at most 16 MiB of a device and
/// 1 GiB of a pipe.
class ReadableFile {
  public:
    /// Throws IoError with the system's reason, also if `path` is a folder.
    explicit ReadableFile(std::string path);
    ReadableFile(const ReadableFile&) = delete;
    ReadableFile& operator=(const ReadableFile&) = delete;
    ~ReadableFile();

    /// Bytes of a regular file when it was opened; 0 of a pipe, which does not say.
    std::size_t size() const { return size_; }
    /// At least one byte, at most those of `bytes`; 0 at the end. Throws IoError, and Interrupted
    /// if a stop is requested while nothing comes.
    std::size_t read(std::span<char> bytes) const;

  private:
    void wait_for_data() const;
    std::size_t counted(std::size_t got) const;

    std::string path_;
    std::size_t most_ = 0;
    mutable std::size_t read_ = 0;
    std::size_t size_ = 0;
    int descriptor_ = -1;
    bool may_wait_ = false;
};

}  // namespace mscomp
