// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace mscomp {

/// A folder of files that appear all at once or not at all. They are written into a hidden folder
/// beside it, which then takes its place in one step; without commit() nothing is changed. Files of
/// the same names are replaced, others stay. What a killed process leaves is removed by the next
/// one that writes to the same place.
///
/// A folder that is a mount point, holds folders, is the current one or lies where nothing can be
/// made beside it stays itself: its files are then moved one by one, which is undone as a whole if
/// one fails, and by the next who writes there if the process was killed meanwhile.
class OutputFolder {
  public:
    /// Throws IoError if nothing can be written there. Makes missing parents.
    explicit OutputFolder(const std::string& folder);
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;
    ~OutputFolder();

    /// Where to write the file that becomes `name`. Throws IoError if that is a folder or device
    /// now.
    std::string path(const std::string& name) const;
    /// A file of an earlier output that goes where the new one has none of that name.
    void drop(const std::string& name);
    /// Throws IoError; then the earlier files still stand.
    void commit();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A few files that appear together or not at all, in folders that hold others: as OutputFolder,
/// their folders stay themselves. Across several folders it is one after the other.
class OutputFiles {
  public:
    /// Throws IoError if one of `paths` cannot be written.
    explicit OutputFiles(const std::vector<std::string>& paths);
    OutputFiles(const OutputFiles&) = delete;
    OutputFiles& operator=(const OutputFiles&) = delete;
    ~OutputFiles();

    /// Where to write what becomes `path`, one of those given.
    std::string path(const std::string& path) const;
    /// Throws IoError; then the earlier files still stand.
    void commit();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Undoes what a killed process left half done in `folder`, and removes what it left there: for who
/// is about to read what it writes to. Never throws.
void recover_folder(const std::string& folder);

/// The name under which a file within an output under way will appear; any other as it is.
std::string final_name(const std::string& path);

}  // namespace mscomp
