// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "consistency.h"
#include "mscomp/acap/feature_rows.h"

namespace mscomp {

/// What improve_consistency does with one start: returns whether the energy fell, and then replaces
/// rotation vectors and summary.
using StartTrial = std::function<bool(
    const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& start,
    std::vector<Eigen::Vector3d>& rotation_vectors, ConsistencySummary& summary)>;

/// For every shape whose turns are not proved to be the best, tries those of the shape before and
/// of the shape after it as further starts, until that helps nowhere, at most three times over all
/// shapes. Even and odd shapes take turns, so that what a shape looks at stands still meanwhile and
/// the result does not depend on the number of threads; a good choice spreads by one shape with
/// each turn, and where a shape has not changed it is not tried again. `rows` and `summaries` (N)
/// are replaced where the energy fell; `after_each` is called after every shape, perhaps from
/// several threads.
void improve_from_neighbors(const ConsistencyGraph& graph, FeatureRows& rows,
                            std::vector<ConsistencySummary>& summaries,
                            const std::function<void()>& after_each,
                            const StartTrial& try_start = improve_consistency);

}  // namespace mscomp
