// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "mscomp/base/feature_set.h"

namespace mscomp {

/// A number for every shape that a feature set may have, and its name in files.
struct PerShapeArray {
    const char* name;
    std::vector<double> FeatureSet::*numbers;
    bool may_be_nan = false;
};

inline constexpr std::array kPerShapeArrays{
    PerShapeArray{"principal_energy", &FeatureSet::principal_energy},
    PerShapeArray{"propagation_energy", &FeatureSet::propagation_energy},
    PerShapeArray{"relaxation_energy", &FeatureSet::relaxation_energy, true},
    PerShapeArray{"consistency_energy", &FeatureSet::consistency_energy},
    PerShapeArray{"consistency_gap", &FeatureSet::consistency_gap},
    PerShapeArray{"largest_jump", &FeatureSet::largest_jump},
    PerShapeArray{"large_jumps", &FeatureSet::large_jumps},
    PerShapeArray{"inherent_jumps", &FeatureSet::inherent_jumps},
    PerShapeArray{"removable_jumps", &FeatureSet::removable_jumps}};

}  // namespace mscomp
