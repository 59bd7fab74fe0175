// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "mscomp/base/error.h"

namespace mscomp {

/// The number in field `index` (from 0; -1 is the last) of a row of metrics.csv, which stands at
/// `where`. Throws InputError if there is none.
template <class Number>
Number metrics_number(std::string_view row, int index, const FilePosition& where);

}  // namespace mscomp
