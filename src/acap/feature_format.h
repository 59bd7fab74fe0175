// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstring>
#include <span>
#include <vector>

#include "mscomp/base/feature_set.h"

namespace mscomp {

// What the writer and the reader of feature files agree on.
inline constexpr const char* kFeatureFormatVersion = "1";
inline constexpr const char* kFeatureLayout = "rx ry rz s11 s12 s13 s22 s23 s33";

/// One number per shape: tensor name, member, and whether NaN has a meaning.
struct PerShapeNumber {
    const char* name;
    std::vector<double> FeatureSet::*member;
    bool may_be_nan = false;
};
inline constexpr std::array<PerShapeNumber, 9> kPerShapeNumbers{
    {{"principal_energy", &FeatureSet::principal_energy},
     {"propagation_energy", &FeatureSet::propagation_energy},
     {"relaxation_energy", &FeatureSet::relaxation_energy, true},
     {"consistency_energy", &FeatureSet::consistency_energy},
     {"consistency_gap", &FeatureSet::consistency_gap},
     {"largest_jump", &FeatureSet::largest_jump},
     {"large_jumps", &FeatureSet::large_jumps},
     {"inherent_jumps", &FeatureSet::inherent_jumps},
     {"removable_jumps", &FeatureSet::removable_jumps}}};

/// The numbers of a vector of fixed-size arrays, one after the other.
template <class T, std::size_t kSize>
std::span<const T> flat(const std::vector<std::array<T, kSize>>& rows) {
    static_assert(sizeof(std::array<T, kSize>) == kSize * sizeof(T));
    return {reinterpret_cast<const T*>(rows.data()), rows.size() * kSize};
}

template <class T, std::size_t kSize>
std::vector<std::array<T, kSize>> rows_of(std::span<const T> numbers) {
    std::vector<std::array<T, kSize>> rows(numbers.size() / kSize);
    if (!rows.empty()) std::memcpy(rows.data(), numbers.data(), numbers.size_bytes());
    return rows;
}

}  // namespace mscomp
