// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// As long as it lives, files in the folder `staged` will appear in `folder`: final_name
/// (mscomp/base/output_folder.h) tells, so that messages name what the user knows.
class StagedName {
  public:
    StagedName(std::string staged, const std::string& folder);
    StagedName(const StagedName&) = delete;
    StagedName& operator=(const StagedName&) = delete;
    ~StagedName();

  private:
    std::string staged_;
};

}  // namespace mscomp
