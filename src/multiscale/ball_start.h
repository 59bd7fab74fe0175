// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/base/distance_rows.h"
#include "mscomp/multiscale/multiscale.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Components to begin with, level after level, by deflation of the whole residual (method §9): the
/// global ones along the main directions of all, then those of each level around where most is
/// left, not more of them close together than `settings.spread` says. Components for which nothing
/// is left are zero.
BallComponents start_balls(const MetricRows& rows, const MultiscaleSettings& settings,
                           DistanceRows& distances);

}  // namespace mscomp
