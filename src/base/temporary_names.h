// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// Remembers a temporary file for remove_temporary_files (mscomp/base/interruption.h) as long as it
/// lives. Beyond a fixed number of files, or of bytes in a name, one is not remembered.
class TemporaryName {
  public:
    TemporaryName() = default;
    explicit TemporaryName(const std::string& path);
    TemporaryName(const TemporaryName&) = delete;
    TemporaryName& operator=(const TemporaryName&) = delete;
    ~TemporaryName() { forget(); }

    /// The file is gone or has another name now.
    void forget();

  private:
    int place_ = -1;
};

}  // namespace mscomp
