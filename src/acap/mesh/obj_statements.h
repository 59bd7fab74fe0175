// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

/// The statements of an OBJ that change no vertex and no face, as they are met.
class ObjStatements {
  public:
    ObjStatements();

    /// Notes a known one; false if it is none.
    bool note_known(std::string_view keyword);
    /// What is not kept of those that were met, some of it several times.
    std::vector<std::string_view> unused() const;

    /// Other programs have statements of their own. Not taken for one is what looks like a damaged
    /// vertex or face, and what no text has.
    static bool may_be_foreign(std::string_view keyword);
    /// "got the keyword ..., expected ..."
    static std::string complaint_about(std::string_view keyword);

  private:
    std::vector<char> is_met_;
};

}  // namespace mscomp
