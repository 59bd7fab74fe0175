// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace mscomp {

/// What is listed of `count` things, ascending; all of them if nothing is. Throws UsageError naming
/// `what` for one that is not there or listed twice.
std::vector<int> listed(std::vector<int> list, int count, const char* what);

}  // namespace mscomp
