// SPDX-License-Identifier: MIT
#include "mscomp/base/made_rows.h"

#include <utility>

namespace mscomp {

std::span<const float> MadeRows::row(int index, const std::function<std::vector<float>()>& make) {
    {
        const std::lock_guard lock(mutex_);
        if (const auto found = rows_.find(index); found != rows_.end()) return found->second;
    }
    std::vector<float> row = make();
    const std::lock_guard lock(mutex_);
    return rows_.try_emplace(index, std::move(row)).first->second;
}

void MadeRows::forget(int index) {
    const std::lock_guard lock(mutex_);
    rows_.erase(index);
}

}  // namespace mscomp
