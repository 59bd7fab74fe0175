// SPDX-License-Identifier: MIT
#include "nn/parameter_set.h"

#include <algorithm>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {

std::int64_t element_count(const Extents& extents) {
    std::int64_t count = 1;
    for (const std::int64_t extent : extents) count *= extent;
    return count;
}

template <class T>
int ParameterSet<T>::add(std::string name, Extents extents) {
    constexpr auto kCacheLine = static_cast<std::int64_t>(64 / sizeof(T));
    const std::int64_t count = element_count(extents);
    const auto offset = static_cast<std::int64_t>(values_.size());
    entries_.push_back({std::move(name), std::move(extents), offset, count, 1.0});
    const auto size = at(offset + (count + kCacheLine - 1) / kCacheLine * kCacheLine);
    for (auto* all : {&values_, &grads_, &moments1_, &moments2_}) all->grow(size);
    live_of_entry_.push_back({{0, count}});
    cut_live();
    return static_cast<int>(entries_.size()) - 1;
}

template <class T>
void ParameterSet<T>::zero_grad() {
    parallel_for(live_piece_count(), [&](std::int64_t piece) {
        for (const Range& range : live_piece(static_cast<int>(piece))) {
            std::fill(grads_.begin() + range.first, grads_.begin() + range.last, T{0});
        }
    });
}

template <class T>
void ParameterSet<T>::set_live(int index, std::vector<Range> ranges) {
    const auto i = at(index);
    const Entry& e = entry(index);
    // What stops being live leaves zeros behind.
    auto next = ranges.begin();
    for (const Range& before : live_of_entry_[i]) {
        for (std::int64_t place = before.first; place < before.last;) {
            while (next != ranges.end() && next->last <= place) ++next;
            const bool is_live = next != ranges.end() && next->first <= place;
            const std::int64_t stop = next == ranges.end() ? before.last
                                      : is_live            ? std::min(next->last, before.last)
                                                           : std::min(next->first, before.last);
            if (!is_live) {
                for (auto* all : {&grads_, &moments1_, &moments2_}) {
                    all->reset(at(e.offset + place), at(e.offset + stop));
                }
            }
            place = stop;
        }
    }
    live_of_entry_[i] = std::move(ranges);
    cut_live();
}

template <class T>
void ParameterSet<T>::set_rate_scale(int index, double scale) {
    entries_[at(index)].rate_scale = scale;
}

template <class T>
void ParameterSet<T>::cut_live() {
    constexpr std::int64_t kPieceValues = std::int64_t{1} << 15;
    live_.clear();
    first_of_piece_.assign(1, 0);
    entry_of_piece_.clear();
    std::int64_t in_piece = 0;
    const auto end_piece = [&](std::size_t entry) {
        first_of_piece_.push_back(live_.size());
        entry_of_piece_.push_back(static_cast<int>(entry));
        in_piece = 0;
    };
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        for (Range range : live_of_entry_[i]) {
            range.first += entries_[i].offset;
            range.last += entries_[i].offset;
            while (range.first < range.last) {
                const std::int64_t stop =
                    std::min(range.last, range.first + kPieceValues - in_piece);
                live_.push_back({range.first, stop});
                in_piece += stop - range.first;
                range.first = stop;
                if (in_piece == kPieceValues) end_piece(i);
            }
        }
        if (in_piece > 0) end_piece(i);
    }
}

template class ParameterSet<float>;
template class ParameterSet<double>;

}  // namespace mscomp::nn
