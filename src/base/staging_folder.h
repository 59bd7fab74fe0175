// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mscomp {

/// A hidden, locked folder in which an output is made ready, with new/ and old/ as
/// in_place_exchange.h says, on the file system of the folder that it is for. Removed when it goes.
class StagingFolder {
  public:
    enum class Place { beside, inside };
    /// For `folder`, a real path. Beside it if possible and asked for, else in it: then it is made
    /// if it is missing. Throws IoError naming it.
    StagingFolder(std::string folder, Place place);
    StagingFolder(const StagingFolder&) = delete;
    StagingFolder& operator=(const StagingFolder&) = delete;
    ~StagingFolder();

    const std::string& path() const { return path_; }
    bool is_inside() const { return is_inside_; }

  private:
    bool make_beside(const std::string& parent);
    int make_in(const std::string& parent, const std::string& name);
    int give_up(int failed);
    bool can_move_into_folder() const;

    std::string folder_, path_;
    bool is_inside_ = false;
    int descriptor_ = -1;
};

}  // namespace mscomp
