// SPDX-License-Identifier: MIT
#include "mscomp/nn/parameter_set.h"

#include <algorithm>
#include <utility>

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
    entries_.push_back({std::move(name), std::move(extents), offset, count});
    const auto size =
        static_cast<std::size_t>(offset + (count + kCacheLine - 1) / kCacheLine * kCacheLine);
    for (auto* all : {&values_, &grads_, &moments1_, &moments2_}) all->grow(size);
    return static_cast<int>(entries_.size()) - 1;
}

template <class T>
void ParameterSet<T>::zero_grad() {
    std::fill(grads_.begin(), grads_.end(), T{0});
}

template class ParameterSet<float>;
template class ParameterSet<double>;

}  // namespace mscomp::nn
