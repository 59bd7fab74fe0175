// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace mscomp {

/// The content of a file, read once and copied once. Not mapped: a file that is cut while it is
/// worked on must lead to a message, not to a crash.
class FileBytes {
  public:
    /// Throws IoError with the system's reason, Interrupted as ReadableFile does.
    explicit FileBytes(const std::string& path);
    std::string_view bytes() const { return {bytes_.get(), size_}; }

  private:
    void grow(std::size_t capacity);

    std::unique_ptr<char[]> bytes_;
    std::size_t size_ = 0;
};

}  // namespace mscomp
