// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/given_components.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Components of another model of features as components to begin with, mapped and of unit length,
/// each on the vertices that it changes.
BallComponents given_balls(const GivenComponents& given, const MetricScale& scale);

/// Throws UsageError unless the levels of `given` are those of the settings, the global ones before
/// them.
void require_levels(const GivenComponents& given, const MultiscaleSettings& settings);

}  // namespace mscomp
