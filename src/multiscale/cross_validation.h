// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/acap/mirror.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/base/shape_features.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// What a training may choose by itself.
struct Choices {
    int global_components = 0;
    int fill_up_to = 0;

    bool operator==(const Choices&) const = default;
};

/// What choosing needs; borrows everything.
struct ChoicePlace {
    const TriangleMesh& reference;
    const std::string& weights;  // edge weights of the features
    DistanceRows& distances;
    const MetricScale& scale;
    const Mirror* mirror;  // null: none
};

struct ChosenBySpaceError {
    Choices choices;
    std::vector<std::string> notes;  // the error of each, for the log
};

/// Of `candidates` the one with the least error in space of training shapes that it has not seen,
/// decoded from their joint codes: threefold, every third shape left out, with half of the rounds
/// of least squares. The first of those that are as good. At least three shapes.
ChosenBySpaceError choose(const std::vector<Choices>& candidates,
                          const MultiscaleSettings& settings, std::uint64_t seed,
                          const ChoicePlace& place, const ShapeFeatures& shapes,
                          const std::vector<int>& train);

}  // namespace mscomp
