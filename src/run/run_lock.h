// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// While it lives no other process writes to the folder of a run or a sweep. The file stays
/// there and says that the rest is of a run, or a sweep, too; the lock itself ends with the
/// process, however that ends. File systems without locks have none.
class RunLock {
  public:
    /// Makes `folder` if it is missing, and in it the file that is locked. Throws IoError at once
    /// if another process has it.
    RunLock(const std::string& folder, std::string file);
    RunLock(const RunLock&) = delete;
    RunLock& operator=(const RunLock&) = delete;
    /// Removes what it has made, unless it is to be kept.
    ~RunLock();

    void keep() { is_kept_ = true; }

  private:
    void open();
    void claim() const;

    std::string folder_, path_;
    int descriptor_ = -1;
    bool has_made_folder_ = false, has_made_file_ = false, is_kept_ = false;
};

}  // namespace mscomp
