// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace mscomp {

// A staging folder holds what becomes of files in another folder:
//   new/   files to be, under their names
//   old/   files whose place they took
//   files  while files are moved: the other folder and the names, so that it can be undone

std::string new_files(const std::string& staging);
std::string old_files(const std::string& staging);

/// Gives `to` the mode and the owner of `from`; false where this user may not.
bool take_mode_and_owner(const std::string& from, const std::string& to);
/// The same for those files of new/ that will replace one in `folder`, as far as possible.
void keep_modes_and_owners(const std::string& folder, const std::string& staging,
                           const std::vector<std::string>& names);

/// Moves the files `names` of new/ into `folder`, and what had their names, or one of `dropped`, to
/// old/. All of it or nothing: what fails is undone and throws IoError; of a killed process
/// remove_staging undoes it. Folders in the way are an IoError. `folder` is meant as seen from
/// here.
void move_into(const std::string& folder, const std::string& staging,
               const std::vector<std::string>& names, const std::vector<std::string>& dropped);

/// Undoes what was moved in part, then removes the staging folder. What cannot be undone now stays,
/// for another try.
void remove_staging(const std::string& staging) noexcept;

}  // namespace mscomp
