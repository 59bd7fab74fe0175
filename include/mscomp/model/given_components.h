// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/model/shape_model.h"

namespace mscomp {

/// The components of a model as another one can begin with them, whatever the first decodes with.
struct GivenComponents {
    int vertex_count = 0;
    std::vector<LevelSize> levels;    // coarse to fine
    std::vector<int> parents;         // (K), as ShapeModel::parents
    std::vector<int> centers;         // (K)
    std::vector<CodeColumn> changes;  // (K) what a change of the code by 1 does to unscaled rows

    int count() const { return static_cast<int>(changes.size()); }
};

/// What each code changes at codes as the training shapes have them, z_m their mean and s_k their
/// deviation, 1 where it is 0: (Dec(z_m + s_k e_k) - Dec(z_m - s_k e_k)) / (2 s_k). The component
/// itself where decoding is linear; where it is not, the secant over the codes that shapes have,
/// with their sign. A vertex that the code leaves alone is not in the column.
GivenComponents given_components(const ShapeModel& model, const CodeTable& codes);

}  // namespace mscomp
