// SPDX-License-Identifier: MIT
#include "mscomp/base/row_cache.h"

#include <cassert>
#include <utility>

namespace mscomp {

std::optional<std::span<const double>> RowCache::find(int key) {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return std::nullopt;
    Entry& entry = found->second;
    entry.round = round_;
    uses_.splice(uses_.begin(), uses_, entry.use);
    return entry.row;
}

std::span<const double> RowCache::put(int key, std::vector<double> row) {
    assert(entries_.find(key) == entries_.end());
    bytes_ += row.size() * sizeof(double);
    uses_.push_front(key);
    Entry& entry =
        entries_.emplace(key, Entry{std::move(row), uses_.begin(), round_}).first->second;
    drop_what_may_go();
    return entry.row;
}

void RowCache::drop_what_may_go() {
    while (bytes_ > limit_) {
        const auto oldest = entries_.find(uses_.back());
        if (oldest->second.round == round_) return;
        bytes_ -= oldest->second.row.size() * sizeof(double);
        entries_.erase(oldest);
        uses_.pop_back();
    }
}

}  // namespace mscomp
