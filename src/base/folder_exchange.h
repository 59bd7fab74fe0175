// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <string>
#include <vector>

namespace mscomp {

/// While it lives, nobody else exchanges the folder, or files in it, for others. Where the folder
/// is missing or the file system has no locks there is none.
class FolderLock {
  public:
    explicit FolderLock(const std::string& folder);
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock();

  private:
    int descriptor_ = -1;
};

/// Puts new/ of `staging` (in_place_exchange.h), which lies beside `folder` and holds the files
/// `names`, into its place in one step. What else is in `folder`, apart from `dropped`, is in it
/// afterwards too. False, and nothing changed, where that cannot be done. Throws IoError if it was
/// done and could not be brought to disk.
bool exchange_folder(const std::string& folder, const std::string& staging,
                     const std::vector<std::string>& names, const std::set<std::string>& dropped);

}  // namespace mscomp
