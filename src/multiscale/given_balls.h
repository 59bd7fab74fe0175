// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/given_components.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Components of another model of features as components to begin with, mapped and of unit length,
/// each on the vertices that it changes. Throws UsageError unless its levels are those of the
/// settings, the global ones before them.
BallComponents given_balls(const GivenComponents& given, const MultiscaleSettings& settings,
                           const MetricScale& scale);

}  // namespace mscomp
