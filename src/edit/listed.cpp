// SPDX-License-Identifier: MIT
#include "listed.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {

std::vector<int> listed(std::vector<int> list, int count, const char* what) {
    if (list.empty()) {
        list.resize(at(count));
        std::iota(list.begin(), list.end(), 0);
        return list;
    }
    std::ranges::sort(list);
    for (std::size_t n = 0; n < list.size(); ++n) {
        if (list[n] < 0 || list[n] >= count) {
            throw UsageError(
                fmt::format("a fit of {} {}, wanted 0 to {}", what, list[n], count - 1));
        }
        if (n > 0 && list[n] == list[n - 1]) {
            throw UsageError(fmt::format("a fit of {} {} twice, wanted it once", what, list[n]));
        }
    }
    return list;
}

}  // namespace mscomp
