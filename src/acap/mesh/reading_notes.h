// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "polygon_mesh.h"

namespace mscomp {

/// What was passed over in, or not taken from, the files of a sequence. Files may come in any
/// order, from several threads and more than once.
class ReadingNotes {
  public:
    void add(int index, const PolygonMesh& mesh);
    /// A sentence for each kind: how often, in how many of the `paths`, and where first.
    std::vector<std::string> warnings(const std::vector<std::string>& paths) const;
    /// Each name once, that of the first file first.
    std::vector<std::string> unused() const;

  private:
    mutable std::mutex mutex_;
    std::map<PassedOver::Kind, std::map<int, PassedOver>> passed_over_;  // by file
    std::map<std::string, int> unused_;                                  // first file
};

}  // namespace mscomp
