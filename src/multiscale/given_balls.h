// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/given_components.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/ball_components.h"
#include "multiscale/row_map.h"

namespace mscomp {

/// Components of another model of the same rows as components to begin with, mapped and of unit
/// length, each on the vertices that it changes.
BallComponents given_balls(const GivenComponents& given, const RowMap& map);

/// Throws UsageError unless the levels of `given` are those of the settings, the global ones before
/// them.
void require_levels(const GivenComponents& given, const MultiscaleSettings& settings);

}  // namespace mscomp
