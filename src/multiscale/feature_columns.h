// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/metric_scale.h"
#include "mscomp/model/shape_model.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// How unscaled features change with each code, (K).
std::vector<CodeColumn> feature_columns(const BallComponents& components, const MetricScale& scale);

}  // namespace mscomp
